//! The sizes of a body that decide whether and how it can be solved.

use crate::mass::{extents, reach, section};
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::{Solid, TriMesh, Vec3, sample};

/// The sizes of a body, its generation and its weakest place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMeasure {
    /// Volume \[m³\].
    pub volume: f64,
    /// Greatest extent L \[m\].
    pub length: f64,
    /// Typical wall thickness t = 2V/A \[m\], at most the least extent.
    pub thickness: f64,
    /// Thickness for bending as a solver sees it \[m\]: `thickness` of
    /// `cullet_geometry::inside::Nearest`.
    pub depth: f64,
    /// Smallest section of several through the body \[m²\].
    pub section: f64,
    /// Volume over the original body's \[1\].
    pub volume_ratio: f64,
    /// How many fractures it has behind it; a plan counts those of one blow once.
    pub generation: u32,
    /// Least strength anywhere in it over its material's \[1\].
    pub weakest: f64,
}

/// Places along each axis at which the section is taken, as shares of the extent.
const STATIONS: [f64; 5] = [0.2, 0.35, 0.5, 0.65, 0.8];

impl BodyMeasure {
    /// Takes the measure of a solid of `volume` \[m³\].
    #[must_use]
    pub fn of(solid: &Solid, volume: f64, volume_ratio: f64, generation: u32) -> Self {
        let mesh = &solid.mesh;
        let size = extents(mesh.vertices.iter());
        let wall = 2.0 * volume / surface(mesh);
        Self {
            volume,
            length: size.max(),
            thickness: wall.min(size.min()),
            depth: depth(mesh, volume).unwrap_or(wall).min(size.min()),
            section: smallest_section(mesh, &size),
            volume_ratio,
            generation,
            weakest: 1.0,
        }
    }
}

/// Points that the thickness is taken from.
const PROBES: f64 = 1000.0;

/// [`Nearest::thickness`] of a body; `None` of one that is nearly all air.
fn depth(mesh: &TriMesh, volume: f64) -> Option<f64> {
    let spacing = libm::cbrt(volume / PROBES);
    let points = sample::poisson(&Inside::new(mesh), spacing, 0).ok()?;
    (!points.is_empty()).then(|| Nearest::new(mesh).thickness(&points))
}

fn surface(mesh: &TriMesh) -> f64 {
    let twice = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(&(c - a)).norm()
    };
    (0..mesh.triangles.len()).map(twice).sum::<f64>() / 2.0
}

fn smallest_section(mesh: &TriMesh, size: &Vec3) -> f64 {
    let far = reach(mesh);
    let mut least = f64::INFINITY;
    for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
        let low = mesh.vertices.iter().map(|p| axis.dot(p)).fold(far, f64::min);
        for station in STATIONS {
            let area = section(mesh, &axis, low + station * size.dot(&axis));
            if area > 0.0 {
                least = least.min(area);
            }
        }
    }
    least
}
