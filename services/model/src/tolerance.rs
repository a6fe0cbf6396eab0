//! What a relative error that is good enough lets a brittle solve leave out (`docs/frontier.md`).

/// Step of a brittle solve over the bound of its stable step: the bound holds for any sampling and
/// any crack, but for small strain; a tenth of compression makes waves faster by as much (F04).
pub const SAFETY: f64 = 0.8;
/// Steps of a brittle solve between looks at what has parted: a crack at Rayleigh's speed comes
/// less than two cells far (F21).
pub const REFRESH: u64 = 4;
/// How much coarser sampled pieces may be for each of the error, ...
const COARSER: f64 = 1.8;
/// ... and at most: pieces of 4.1 times the mass, on as many nodes each.
const COARSEST: f64 = 1.6;
/// How much longer a step may be for each of the error, ...
const LONGER: f64 = 0.5;
/// ... and how long it may be at most, over the bound of small strain: what leaves it there is
/// solved again with half of it.
const LONGEST: f64 = 1.0;
/// How many times more steps may pass between looks at what has parted, for each of the error, ...
const RARER: f64 = 1.5;
/// ... and at most.
const RAREST: f64 = 2.0;
/// Share of the broken points that may break within a transit when a solve ends, over the error.
const SMALL: f64 = 0.06;

/// Relative error of the pieces that is good enough \[1\]; `None`: as true as can be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerance(pub Option<f64>);

impl Tolerance {
    fn error(self) -> f64 {
        self.0.unwrap_or(0.0)
    }

    /// How many times larger pieces are sampled than the grid allows, and how many times farther
    /// apart the nodes of the lattice are that cuts them: on a coarser lattice without larger
    /// pieces the least would join whole ones.
    #[must_use]
    pub fn coarseness(self) -> f64 {
        (1.0 + COARSER * self.error()).min(COARSEST)
    }

    /// Step over the bound of the stable step of small strain.
    #[must_use]
    pub fn step(self) -> f64 {
        (SAFETY * (1.0 + LONGER * self.error())).min(LONGEST)
    }

    /// Steps between looks at what has parted.
    #[must_use]
    pub fn refresh(self) -> u64 {
        (REFRESH as f64 * (1.0 + RARER * self.error()).min(RAREST)) as u64
    }

    /// Share of the broken points that may break within a transit when a solve of a crushed body
    /// ends.
    #[must_use]
    pub fn growth(self) -> Option<f64> {
        self.0.map(|error| SMALL * error)
    }
}

#[cfg(test)]
mod tests {
    use crate::Tolerance;

    #[test]
    fn an_error_loosens_what_it_may_and_none_nothing() {
        let all = |error: Option<f64>| {
            let one = Tolerance(error);
            (one.coarseness(), one.step(), one.refresh(), one.growth())
        };
        assert_eq!(all(None), (1.0, 0.8, 4, None));
        assert_eq!(all(Some(0.1)), (1.0 + 1.8 * 0.1, 0.8 * 1.05, 4, Some(0.06 * 0.1)));
        assert_eq!(all(Some(0.5)), (1.6, 1.0, 7, Some(0.03)));
        assert_eq!(all(Some(1.0)), (1.6, 1.0, 8, Some(0.06)));
    }
}
