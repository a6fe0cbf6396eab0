//! Vectors as three numbers in a row, for the types that travel.

/// A vector as `[x, y, z]`.
pub(crate) mod vector {
    use cullet_geometry::Vec3;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(vector: &Vec3, to: S) -> Result<S::Ok, S::Error> {
        <[f64; 3]>::from(*vector).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec3, D::Error> {
        <[f64; 3]>::deserialize(from).map(Vec3::from)
    }
}
