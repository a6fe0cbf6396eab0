//! A laminated plate: its plies crack as a plain plate of its thickness does, and the interlayer
//! holds the pieces. One body comes of it, with its cracks open in it; where the striker has more
//! energy left than tears the interlayer under it, what lies in the hole parts from the rest.
//!
//! The plies are taken to bend as one (Γ = 1 of Wölfel and Bennison), as they do in short hits on a
//! stiff interlayer, and the film is taken to tear over the hole only: it stretches farther out in
//! truth, and holds more than is said here.

use super::PlateSolve;
use super::field::ShellField;
use cullet_fragment::cut::{self, CutPart, CutSettings};
use cullet_fragment::finish::{Finish, FinishedParts};
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::{Sheet, Solid, Surface, TriMesh, Vec3};
use cullet_model::{Failure, Fragment, Fragmentation, Interlayer};
use cullet_simd::Real;
use std::f64::consts::PI;

/// Radius of the hole beyond the contact's, in thicknesses.
const BEYOND: f64 = 2.0;

/// A direction that no wall is likely to lie along: of the two faces of a crack the one that looks
/// along it is kept.
const ALONG: [f64; 3] = [0.613_7, 0.789_5, 0.011_3];

/// What becomes of the plate.
pub(super) fn finish<R: Real>(
    solve: &mut PlateSolve<R>,
    interlayer: &Interlayer,
) -> Result<Fragmentation, Failure> {
    let mut plain = solve.finish()?;
    // As the parts are in the body's frame.
    let body = super::frame::of_body(&solve.local.solid, &solve.plate);
    let cracked = plain.fragments.len() > 1 || !plain.debris.is_empty();
    if !cracked {
        return Ok(plain);
    }
    let pieces = plain.fragments.len();
    let sheet = cracks(&plain.fragments);
    let torn = Torn::new(solve, interlayer);
    plain.report.details.extend(torn.told());
    if torn.is_open() {
        return hole(solve, &torn, sheet, plain);
    }
    plain.report.warnings.push(format!(
        "laminated: the interlayer holds {pieces} pieces; {:.1} J of the strikers are left, and it \
         takes {:.1} J to tear it",
        torn.left, torn.holds
    ));
    let hulls = convex_parts(&body, HullSettings::default());
    let (velocity, spin) = (Vec3::zeros(), Vec3::zeros());
    plain.fragments = vec![Fragment { solid: body, hulls, velocity, spin, sheet }];
    (plain.sampled, plain.debris) = (vec![false], Vec::new());
    Ok(plain)
}
