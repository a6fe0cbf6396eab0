//! Which instructions of the processor are used.

use fearless_simd::Level;

/// Instructions of the processor; all give the same bits.
#[derive(Clone, Copy, Debug)]
pub struct SimdLevel(Level);

impl SimdLevel {
    /// For `fearless_simd::dispatch`.
    #[must_use]
    pub fn level(self) -> Level {
        self.0
    }

    /// The widest that this processor has.
    #[must_use]
    pub fn best() -> Self {
        Self(Level::new())
    }

    /// What every processor of this architecture has.
    #[must_use]
    pub fn portable() -> Self {
        Self(Level::baseline())
    }

    /// All that this processor has, the widest first.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = vec![Level::new()];
        #[cfg(target_arch = "x86_64")]
        if let (Some(_), Some(narrower)) = (Level::new().as_avx512(), Level::new().as_avx2()) {
            all.push(Level::Avx2(narrower));
        }
        all.push(Level::baseline());
        all.into_iter().map(Self).collect()
    }
}

impl std::fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = format!("{:?}", self.0);
        f.write_str(name.split('(').next().unwrap_or_default())
    }
}
