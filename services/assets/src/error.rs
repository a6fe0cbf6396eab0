//! Why bytes are not a mesh.

/// Why bytes are not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFileError {
    /// The name's end is no format that is read here.
    #[error(
        "\"{name}\" is no mesh that is read here: those end in .obj, .stl, .ply, .glb, \
         .gltf, .json"
    )]
    UnknownFormat {
        /// The file's name.
        name: String,
    },
    /// The text or the bytes break the format.
    #[error("{}{reason}", .line.map(|line| format!("line {line}: ")).unwrap_or_default())]
    Malformed {
        /// Line of a text format, from 1.
        line: Option<usize>,
        /// What the reader said.
        reason: String,
    },
    /// The data ends before what its header promises.
    #[error("the file ends early: {have} of {need} bytes")]
    Truncated {
        /// Bytes there.
        have: u64,
        /// Bytes promised.
        need: u64,
    },
    /// A face names a corner that is not there.
    #[error("face {face} names corner {index}, but there are {count}")]
    IndexOutOfRange {
        /// Which face, from 0.
        face: usize,
        /// Which corner.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// A coordinate is not finite or too large.
    #[error("corner {vertex} has the coordinate {value}; it must be finite and within ±{limit:e}")]
    BadCoordinate {
        /// Which corner, from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
        /// The bound.
        limit: f64,
    },
    /// There is not one triangle.
    #[error("the file has no triangles")]
    Empty,
    /// More triangles than accepted.
    #[error("the file has {count} triangles; at most {limit} are read")]
    TooLarge {
        /// How many there are.
        count: usize,
        /// The bound.
        limit: usize,
    },
    /// A file that it needs is not to be had.
    #[error(
        "it needs the file \"{name}\", which is not beside it; one outside its folder is not read"
    )]
    Beside {
        /// The file that it names.
        name: String,
    },
    /// Something of the format that is not read here.
    #[error("{what} is not read here")]
    Unsupported {
        /// What the value is.
        what: String,
    },
}
