//! NURBS surfaces as JSON, in the form that NURBS-Python (`geomdl.exchange.export_json`) writes and
//! `rw3dm` makes of Rhino's files: `shape.data`, a list of patches. Control points run along v
//! first, and have their weights beside them.

use super::raw::Raw;
use super::{MAX_COORDINATE, MeshFileError};
use cullet_geometry::Vec3;
use cullet_geometry::nurbs::{NurbsError, NurbsPatch, SplineAxis, tessellate};
use serde::Deserialize;

/// Most control points of a file.
const MOST_POINTS: usize = 200_000;

#[derive(Deserialize)]
struct SurfaceFile {
    shape: PatchList,
}

#[derive(Deserialize)]
struct PatchList {
    #[serde(rename = "type")]
    kind: String,
    data: Vec<WrittenPatch>,
}

#[derive(Deserialize)]
struct WrittenPatch {
    degree_u: usize,
    degree_v: usize,
    knotvector_u: Vec<f64>,
    knotvector_v: Vec<f64>,
    size_u: usize,
    size_v: usize,
    control_points: ControlPoints,
    trims: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
struct ControlPoints {
    points: Vec<[f64; 3]>,
    weights: Option<Vec<f64>>,
}

/// The triangles of the patches of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    let file: SurfaceFile = serde_json::from_slice(bytes).map_err(|error| {
        MeshFileError::Malformed { line: Some(error.line()), reason: error.to_string() }
    })?;
    let PatchList { kind, data } = file.shape;
    if kind != "surface" {
        return Err(MeshFileError::Unsupported { what: format!("a shape of type \"{kind}\"") });
    }
    if data.is_empty() {
        return Err(MeshFileError::Empty);
    }
    let points = data.iter().map(|patch| patch.control_points.points.len()).sum::<usize>();
    if points > MOST_POINTS {
        let what = format!("a surface of {points} control points, more than {MOST_POINTS},");
        return Err(MeshFileError::Unsupported { what });
    }
    let patches: Result<Vec<NurbsPatch>, MeshFileError> =
        data.into_iter().enumerate().map(|(k, patch)| patch.made(k)).collect();
    let mesh = tessellate(&patches?);
    Ok(Raw { vertices: mesh.vertices, triangles: mesh.triangles, ..Raw::default() })
}

impl WrittenPatch {
    fn made(self, k: usize) -> Result<NurbsPatch, MeshFileError> {
        let bad = |why: String| {
            let reason = format!("patch {k}: {why}");
            MeshFileError::Malformed { line: None, reason }
        };
        let wrong = |error: NurbsError| bad(error.to_string());
        if self.trims.is_some() {
            let what = format!("patch {k}, which is trimmed,");
            return Err(MeshFileError::Unsupported { what });
        }
        let [u, v] = [(self.degree_u, self.knotvector_u), (self.degree_v, self.knotvector_v)]
            .map(|(degree, knots)| SplineAxis::clamped(degree, knots));
        let axes = [u.map_err(wrong)?, v.map_err(wrong)?];
        let ControlPoints { points, weights } = self.control_points;
        for (name, size, axis) in [("u", self.size_u, &axes[0]), ("v", self.size_v, &axes[1])] {
            let wanted = axis.functions();
            if size != wanted {
                let why = format!("size_{name} is {size}, but its knots ask for {wanted}");
                return Err(bad(why));
            }
        }
        let weights = weights.unwrap_or_else(|| vec![1.0; points.len()]);
        let (wide, high) = (self.size_u, self.size_v);
        for (what, found) in [("control points", points.len()), ("weights", weights.len())] {
            if found != wide * high {
                return Err(bad(format!("{found} {what}, but the sizes ask for {}", wide * high)));
            }
        }
        let far = points.iter().flatten().find(|x| x.is_nan() || x.abs() > MAX_COORDINATE);
        if let Some(x) = far {
            return Err(bad(format!("a coordinate is {x}; it must be within ±{MAX_COORDINATE:e}")));
        }
        let order = || (0..high).flat_map(|v| (0..wide).map(move |u| v + u * high));
        let points = order().map(|k| Vec3::from(points[k])).collect();
        let weights = order().map(|k| weights[k]).collect();
        NurbsPatch::new(axes, points, weights).map_err(wrong)
    }
}
