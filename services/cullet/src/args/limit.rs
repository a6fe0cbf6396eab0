//! The memory limit of a job.

/// The limit as it is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Memory {
    /// The memory of the machine, less a reserve, divided among workers that start together.
    Auto,
    /// No limit.
    None,
    /// So many MiB.
    Mib(u64),
}

/// The least limit: less than a job process holds before it has a job \[MiB\].
const LEAST: u64 = 16;

impl Memory {
    /// The limit of each of this many jobs at once \[bytes\].
    pub(crate) fn bytes(self, jobs: usize) -> Option<u64> {
        match self {
            Self::Auto => cullet_worker::memory::share(jobs),
            Self::None => None,
            Self::Mib(mib) => Some(mib << 20),
        }
    }

    /// The arguments that pass it on to each of this many workers.
    pub(crate) fn words(self, workers: usize) -> [String; 2] {
        let word = self.bytes(workers).map(|bytes| (bytes >> 20).max(LEAST).to_string());
        ["--memory".to_owned(), word.unwrap_or_else(|| "none".to_owned())]
    }
}

pub(crate) fn memory(text: &str) -> Result<Memory, String> {
    match (text, text.parse()) {
        ("auto", _) => Ok(Memory::Auto),
        ("none", _) => Ok(Memory::None),
        (_, Ok(mib)) if (LEAST..=u64::MAX >> 20).contains(&mib) => Ok(Memory::Mib(mib)),
        _ => Err(format!("a memory limit is auto, none, or a number of MiB of at least {LEAST}")),
    }
}

#[cfg(test)]
mod tests {
    use super::{Memory, memory};

    #[test]
    fn a_limit_is_read_and_handed_on() {
        assert_eq!(memory("auto"), Ok(Memory::Auto));
        assert_eq!(memory("none"), Ok(Memory::None));
        assert_eq!(memory("3500"), Ok(Memory::Mib(3500)));
        for bad in ["", "15", "-1", "4G", "18446744073709551615"] {
            let said = memory(bad).expect_err(bad);
            assert!(said.contains("at least 16"), "{said}");
        }
        assert_eq!(Memory::None.words(3), ["--memory", "none"]);
        assert_eq!(Memory::Mib(64).words(3), ["--memory", "64"]);
        let word = Memory::Auto.words(2)[1].clone();
        assert!(word == "none" || memory(&word).is_ok(), "{word}");
    }
}
