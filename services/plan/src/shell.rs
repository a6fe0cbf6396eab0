//! Whether a body is a thin plate or a thin curved wall that is hit on its face: then the shell
//! family solves it, for a tenth of a solid's price [gates 4 and 7].

use cullet_geometry::midsurface::WallOutline;
use cullet_geometry::plate::Plate;
use cullet_geometry::{Solid, TriMesh};
use cullet_model::Material;
use cullet_world::{BodyMeasure, BodyView, Hit};

/// Thickness over the smaller extent up to which a plate is solved as a shell [gate 4].
const SLENDER: f64 = 0.1;

/// Closing speed up to which a shell is asked \[m/s\]: faster, a striker only punches through one,
/// and what happens in the thickness decides \[measured: R7\].
const FASTEST: f64 = 50.0;

/// Least share of a hit's direction across the plate: hits along it crush an edge, which a shell
/// knows nothing of.
const ACROSS: f64 = 0.3;

/// Stress of a blow over the strength, or over the yield stress of a metal, below which a sheet
/// stays as it is: waves that come back from the rim may double what the first makes.
pub(crate) const BLOW_SAFETY: f64 = 0.5;

/// Extent of a sheet over its thickness that the stress under a blow is taken for; it goes by the
/// logarithm.
const WIDE: f64 = 150.0;

/// A force in the middle of a clamped square plate over what it yields there, times a²/D \[1\]
/// \[Timoshenko & Woinowsky-Krieger 1959\]: no plate that is held otherwise is stiffer.
const STIFFNESS: f64 = 178.6;

/// Bending stress \[Pa\] under a blow on a sheet: (1 + ν)(0.485 ln(a/t) + 0.52) F/t² \[Timoshenko
/// & Woinowsky-Krieger 1959, a clamped plate\]. Until a wave comes back F is at most 8√(Dρt) v
/// \[Zener 1941\], which goes as t²; on a sheet that is `held` it may grow further, to √(2kU) of
/// the energy U of the hit and the stiffness k.
pub(crate) fn blow_stress(material: &Material, body: &BodyMeasure, hit: &Hit, held: bool) -> f64 {
    let Material { density, young, poisson, .. } = *material;
    let rigidity = young / (12.0 * (1.0 - poisson * poisson));
    let passing = 8.0 * (rigidity * density).sqrt() * hit.impact.closing_speed;
    let still = (2.0 * STIFFNESS * rigidity * hit.impact.energy / body.volume).sqrt();
    let force = if held { passing.max(still) } else { passing };
    (1.0 + poisson) * (0.485 * libm::log(WIDE) + 0.52) * force
}

/// The thin plate that a mesh is.
///
/// # Errors
/// What it lacks, to follow on "and".
pub fn thin_plate(mesh: &TriMesh) -> Result<Plate, String> {
    let plate = Plate::of_mesh(mesh).map_err(|why| format!("this is none: {why}"))?;
    let ratio = plate.thickness / plate.size[0].min(plate.size[1]);
    match ratio <= SLENDER {
        true => Ok(plate),
        false => Err(format!("this is {ratio:.3} times as thick as it is wide, not {SLENDER}")),
    }
}

/// The thin wall that a solid is, and how many times as wide as thick.
///
/// # Errors
/// What it lacks, to follow on "and".
pub fn thin_wall(solid: &Solid) -> Result<(WallOutline, f64), String> {
    let mesh = &solid.mesh;
    // Most bodies are solid: 2V/A of a wall is its thickness.
    let area = 0.5 * mesh.area();
    let ratio = mesh.signed_volume() / area / area.sqrt();
    if ratio > SLENDER {
        return Err(format!("this is {ratio:.3} times as thick as it is wide, not {SLENDER}"));
    }
    let wall = WallOutline::of_solid(solid).map_err(|why| format!("this is none: {why}"))?;
    let times = wall.width / wall.thickness;
    match times * SLENDER >= 1.0 {
        true => Ok((wall, times)),
        false => Err(format!("this is {times:.1} times as wide as it is thick, not 10")),
    }
}

/// Why a body of treated glass is solved as a shell, however it is hit; nothing where it is no thin
/// plate or wall, as most fragments are not: these are taken as annealed glass.
pub(crate) fn treated(view: &BodyView<'_>) -> Option<String> {
    let thin = thin_plate(&view.solid.mesh).is_ok() || thin_wall(view.solid).is_ok();
    thin.then(|| "a thin wall of treated glass: a shell".to_owned())
}

/// Why the body is solved as a shell; nothing where it is not.
pub(crate) fn reason(view: &BodyView<'_>, hits: &[Hit]) -> Option<String> {
    if hits.iter().any(|hit| hit.impact.closing_speed > FASTEST) {
        return None;
    }
    let mesh = &view.solid.mesh;
    match thin_plate(mesh) {
        Ok(plate) => {
            let normal = plate.pose.rotation * cullet_geometry::Vec3::z();
            let across = |hit: &Hit| hit.impact.normal.dot(&normal).abs() >= ACROSS;
            hits.iter().all(across).then(|| {
                let times = plate.size[0].min(plate.size[1]) / plate.thickness;
                format!("a plate {times:.0} times as wide as it is thick, hit on its face: a shell")
            })
        }
        Err(_) => curved(view.solid, hits),
    }
}

/// The same of a body that is no plate.
fn curved(solid: &Solid, hits: &[Hit]) -> Option<String> {
    let (wall, times) = thin_wall(solid).ok()?;
    let along = |hit: &Hit| wall.across(&solid.mesh, hit.impact.point, &hit.impact.normal);
    hits.iter().all(|hit| along(hit) >= ACROSS).then(|| {
        format!("a curved wall {times:.0} times as wide as it is thick, hit on its face: a shell")
    })
}
