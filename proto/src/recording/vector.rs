//! A point or vector in a message.

use super::schema::{MessageDeclaration, message};

message! {
    /// A point or vector.
    #[derive(Copy)]
    Vector3 {
        /// First component.
        "1" [double] x: f64,
        /// Second component.
        "2" [double] y: f64,
        /// Third component.
        "3" [double] z: f64,
    }
}

/// As the schema has it.
pub(super) fn declaration() -> MessageDeclaration {
    Vector3::declaration()
}
