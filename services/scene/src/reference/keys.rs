//! The keys of a type, in the order in which it declares them.
//!
//! A JSON schema sorts its keys by name. The derived readers know the order: when they refuse an
//! unknown key, they name the keys that they take.

use serde::de::value::MapDeserializer;
use serde::de::{self, DeserializeOwned};
use std::fmt;

/// What a reader refuses a table with, as far as that names the keys that it takes.
#[derive(Debug)]
struct Refused(&'static [&'static str]);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected one of {:?}", self.0)
    }
}

impl std::error::Error for Refused {}

impl de::Error for Refused {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self(&[])
    }

    fn unknown_field(_: &str, expected: &'static [&'static str]) -> Self {
        Self(expected)
    }
}

/// The keys of a table; of a table of several kinds, the keys of that `kind` beside `kind` itself.
pub(super) fn keys_of<T: DeserializeOwned>(kind: Option<&str>) -> Vec<&'static str> {
    let entries = kind.map(|kind| ("kind", kind)).into_iter().chain([("no such key", "")]);
    match T::deserialize(MapDeserializer::<_, Refused>::new(entries)) {
        Ok(_) => Vec::new(),
        Err(Refused(keys)) => keys.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::keys_of;
    use crate::format::{Shape, Tiers, View};

    #[test]
    fn keys_come_as_they_are_declared() {
        assert_eq!(keys_of::<Tiers>(None), ["tiny", "small"]);
        assert_eq!(keys_of::<View>(None), ["eye", "target", "field", "start", "end"]);
        let cone = ["radius", "top_radius", "height", "segments"];
        assert_eq!(keys_of::<Shape>(Some("cone")), cone);
    }
}
