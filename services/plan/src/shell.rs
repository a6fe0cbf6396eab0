//! Whether a body is a thin plate or a thin curved wall that is hit on its face: then the shell
//! family solves it, for a tenth of a solid's price [gates 4 and 7].

use cullet_geometry::TriMesh;
use cullet_geometry::midsurface::WallOutline;
use cullet_geometry::plate::Plate;
use cullet_model::Material;
use cullet_world::{BodyView, Hit};

/// Thickness over the smaller extent up to which a plate is solved as a shell [gate 4].
const SLENDER: f64 = 0.1;

/// Closing speed up to which a shell is asked \[m/s\]: faster, a striker only punches through one,
/// and what happens in the thickness decides \[measured: R7\].
const FASTEST: f64 = 50.0;

/// Least share of a hit's direction across the plate: hits along it crush an edge, which a shell
/// knows nothing of.
const ACROSS: f64 = 0.7;

/// Stress of a blow over the yield stress below which a metal stays as it is: waves that come back
/// from the rim may double what the first makes.
pub(crate) const YIELD_SAFETY: f64 = 0.5;

/// Extent of a sheet over its thickness that the stress under a blow is taken for; it goes by the
/// logarithm.
const WIDE: f64 = 150.0;

/// Bending stress under a blow at a closing speed of `speed` \[m/s\], for a sheet of any thickness:
/// (1 + ν)(0.485 ln(a/t) + 0.52) F/t² \[Timoshenko & Woinowsky-Krieger 1959, a clamped plate\] with
/// F = 8√(Dρt) v, the most that pushes while no wave has come back \[Zener 1941\], which goes as t²
/// \[Pa\].
pub(crate) fn blow_stress(material: &Material, speed: f64) -> f64 {
    let Material { density, young, poisson, .. } = *material;
    let force = 8.0 * (young * density / (12.0 * (1.0 - poisson * poisson))).sqrt() * speed;
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

/// Why a body of treated glass is solved as a shell, however it is hit; nothing where it is no thin
/// plate, as most fragments are not: these are taken as annealed glass.
pub(crate) fn treated(view: &BodyView<'_>) -> Option<String> {
    thin_plate(&view.solid.mesh).is_ok().then(|| "a plate of treated glass: a shell".to_owned())
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
        // The walls of a shard are seldom told from its cracks.
        Err(_) if view.generation == 0 => curved(mesh, hits),
        Err(_) => None,
    }
}

/// The same of a body that is no plate.
fn curved(mesh: &TriMesh, hits: &[Hit]) -> Option<String> {
    // Most bodies are solid: 2V/A of a wall is its thickness.
    let area = 0.5 * mesh.area();
    if mesh.signed_volume() / area > SLENDER * area.sqrt() {
        return None;
    }
    let wall = WallOutline::of_mesh(mesh).ok()?;
    let times = wall.width / wall.thickness;
    let across = |hit: &Hit| wall.across(mesh, hit.impact.point, &hit.impact.normal) >= ACROSS;
    (times * SLENDER >= 1.0 && hits.iter().all(across)).then(|| {
        format!("a curved wall {times:.0} times as wide as it is thick, hit on its face: a shell")
    })
}
