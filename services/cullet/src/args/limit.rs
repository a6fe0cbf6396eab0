//! Numbers: the memory limit of a job, how long a worker may be idle, and any that is whole.

use std::ops::RangeInclusive;
use std::time::Duration;

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

/// A reader of whole numbers in a range, which says what is wanted in place of anything else.
pub(crate) fn read_whole<T: TryFrom<i64>>(
    range: RangeInclusive<i64>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| {
            let least = range.start();
            match *range.end() {
                i64::MAX => format!("it must be a whole number of at least {least}"),
                most => format!("it must be a whole number from {least} to {most}"),
            }
        })
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

/// Units of a duration and what one of each is \[s\]; a bare number is in seconds.
const UNITS: [(&str, f64); 6] =
    [("min", 60.0), ("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0), ("", 1.0)];
/// Shortest and longest duration \[s\].
const SHORTEST: f64 = 1.0;
const LONGEST: f64 = 31.0 * 86_400.0;

/// A duration: seconds, or a number with a unit.
pub(crate) fn duration(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let read = UNITS.iter().find_map(|(unit, seconds)| {
        let number: f64 = text.strip_suffix(unit)?.trim_end().parse().ok()?;
        Some(number * seconds)
    });
    let fits = read.filter(|seconds| (SHORTEST..=LONGEST).contains(seconds));
    fits.map(Duration::from_secs_f64).ok_or_else(|| {
        "a duration is a number of seconds, or has a unit, such as 90s, 5min or 2h; it is from 1 s \
         to 744 h"
            .to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::{Memory, duration, memory, read_whole};
    use crate::args::Cli;
    use clap::CommandFactory;
    use clap::error::ErrorKind;
    use std::time::Duration;

    #[test]
    fn a_whole_number_is_told_with_its_bounds() {
        let read = read_whole::<u16>(1..=256);
        assert_eq!((read("1"), read("256")), (Ok(1), Ok(256)));
        for bad in ["", "0", "257", "two", "1.5", "-1", "99999999999999999999"] {
            assert_eq!(read(bad), Err("it must be a whole number from 1 to 256".to_owned()));
        }
        let least = "it must be a whole number of at least 1".to_owned();
        assert_eq!(read_whole::<usize>(1..=i64::MAX)("0"), Err(least));
        assert_eq!(read_whole::<i32>(-100..=100)("-100"), Ok(-100));
    }

    #[test]
    fn no_argument_is_refused_in_the_words_of_a_library() {
        let mut refused = 0;
        for command in Cli::command().get_subcommands() {
            let takes = |arg: &&clap::Arg| arg.get_action().takes_values();
            for name in command.get_arguments().filter(takes).filter_map(clap::Arg::get_long) {
                let value = format!("--{name}=no such thing");
                let call = ["cullet", command.get_name(), &value];
                let Err(error) = Cli::command().try_get_matches_from(call) else { continue };
                if error.kind() == ErrorKind::ValueValidation {
                    refused += 1;
                    let told = error.to_string();
                    let foreign = ["invalid digit", "invalid float", "invalid socket"];
                    assert!(!foreign.iter().any(|words| told.contains(words)), "{told}");
                }
            }
        }
        assert!(refused > 40, "{refused}");
    }

    #[test]
    fn a_duration_is_in_seconds_or_has_a_unit() {
        for (text, millis) in [
            ("90", 90_000),
            ("1.5", 1_500),
            ("90s", 90_000),
            ("2500 ms", 2_500),
            ("5min", 300_000),
            ("5m", 300_000),
            ("2h", 7_200_000),
        ] {
            assert_eq!(duration(text), Ok(Duration::from_millis(millis)), "{text}");
        }
        for bad in ["", "s", "5 d", "0", "0.5s", "-3", "nan", "inf", "745h", "1e400"] {
            let said = duration(bad).expect_err(bad);
            assert!(said.contains("90s") && said.contains("1 s to 744 h"), "{said}");
        }
    }

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
