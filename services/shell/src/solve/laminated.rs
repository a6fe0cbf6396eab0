//! A laminated wall: its plies crack as a plain one of its thickness does, and the interlayer
//! holds the pieces. One body comes of it, with its cracks open in it; where the striker has more
//! energy left than tears the interlayer under it, what lies in the hole parts from the rest.
//!
//! The plies are taken to bend as one (Γ = 1 of Wölfel and Bennison), as they do in short hits on a
//! stiff interlayer, and the film is taken to tear over the hole only: it stretches farther out in
//! truth, and holds more than is said here.

use super::ShellSolve;
use super::field::ShellField;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::inside::Inside;
use cullet_geometry::{Sheet, Surface, Vec3};
use cullet_model::{Failure, Fragment, FragmentOrigin, Fragmentation, Interlayer};
use cullet_simd::Real;
use std::f64::consts::PI;

/// Radius of the hole beyond the contact's, in thicknesses.
const BEYOND: f64 = 2.0;

/// A direction that hardly any wall lies along: of the two faces of a crack the one that looks
/// along it is kept.
const ALONG: [f64; 3] = [0.613_7, 0.783_5, 0.097_3];

/// Where a striker may go through.
#[derive(Clone, Copy, Debug)]
struct StruckPlace {
    /// On the midsurface \[m\].
    place: Vec3,
    /// Radius of the hole \[m\].
    radius: f64,
    /// Energy that the striker has left \[J\].
    left: f64,
    /// Energy that tears the interlayer there \[J\].
    holds: f64,
}

impl StruckPlace {
    fn has(&self, place: &Vec3) -> bool {
        (place - self.place).norm() <= self.radius
    }

    fn is_torn(&self) -> bool {
        self.left > self.holds
    }
}

/// What becomes of it.
pub(super) fn finish<R: Real, const N: usize>(
    solve: &mut ShellSolve<R, N>,
    interlayer: &Interlayer,
) -> Result<Fragmentation, Failure> {
    let mut plain = solve.finish()?;
    if plain.is_intact() {
        return Ok(plain);
    }
    let places = places(solve, interlayer);
    let (pieces, sheet) = (plain.fragments.len(), cracks(&plain.fragments));
    let left: f64 = places.iter().map(|one| one.left).sum();
    let holds: f64 = places.iter().map(|one| one.holds).sum();
    let said = format!(
        "laminated: the interlayer holds what would be {pieces} pieces; {left:.2} J of the \
         strikers are left, and it takes {holds:.2} J to tear it"
    );
    let crack_area = plain.report.crack_area;
    if places.iter().any(StruckPlace::is_torn) {
        let mut open = solve.finish_field(holed(solve, &places))?;
        if let Some(rest) = open.fragments.first_mut() {
            rest.sheet = sheet.clipped(&Inside::new(&rest.solid.mesh));
        }
        open.report.warnings.push(said);
        plain = open;
    } else {
        let solid = super::frame::of_body(&solve.local.solid, &solve.wall.pose);
        let hulls = convex_parts(&solid, HullSettings::default());
        let (velocity, spin) = (Vec3::zeros(), Vec3::zeros());
        plain.fragments = vec![Fragment { solid, hulls, velocity, spin, sheet }];
        (plain.origins, plain.debris) = (vec![FragmentOrigin::Solved], Vec::new());
        (plain.report.crack_area, plain.report.fracture_energy) = (0.0, 0.0);
        plain.report.warnings.push(said);
    }
    let report = std::mem::take(&mut plain.report);
    plain.report = report
        .with("energy_left_of_strikers", "J", left)
        .with("energy_of_interlayer", "J", holds)
        .with("area_of_held_cracks", "m²", crack_area)
        .with("pieces_held", "1", pieces as f64);
    Ok(plain)
}

fn places<R: Real, const N: usize>(
    solve: &ShellSolve<R, N>,
    interlayer: &Interlayer,
) -> Vec<StruckPlace> {
    let strikers = solve.strikers.iter().zip(&solve.local.impacts);
    let place = |(striker, hit): (&super::contact::ShellStriker, &cullet_model::Impact)| {
        let patch = striker.patch();
        let radius = patch.radius + BEYOND * solve.wall.typical;
        let speed = striker.left().max(0.0);
        StruckPlace {
            place: patch.place,
            radius,
            left: hit.energy * speed * speed,
            holds: interlayer.tear_energy() * PI * radius * radius,
        }
    };
    strikers.map(place).collect()
}

/// The points of the shell, of which all that are in no hole are of one part.
fn holed<R: Real, const N: usize>(solve: &ShellSolve<R, N>, places: &[StruckPlace]) -> ShellField {
    let mut field = ShellField::new(solve);
    let rest = field.pieces.found;
    field.pieces.found += 1;
    for (p, place) in field.positions.iter().enumerate() {
        let piece = &mut field.pieces.of[p];
        match places.iter().any(|one| one.is_torn() && one.has(place)) {
            true => *piece = piece.map(|k| if k < rest { k } else { k + 1 }),
            false => {
                *piece = Some(rest);
                (field.damage[p], field.times[p]) = (0.0, f64::INFINITY);
            }
        }
    }
    field
}

/// The cracks between fragments, and those that end in them: one face of each.
fn cracks(fragments: &[Fragment]) -> Sheet {
    let mut sheet = Sheet::default();
    for fragment in fragments {
        sheet.append(&fragment.sheet);
        let mesh = &fragment.solid.mesh;
        for (t, surface) in fragment.solid.surface.iter().enumerate() {
            let Surface::Crack { damage_time, front_speed, parent: 0 } = surface else { continue };
            let [a, b, c] = mesh.corners(t);
            if (b - a).cross(&(c - a)).dot(&Vec3::from(ALONG)) <= 0.0 {
                continue;
            }
            let first = sheet.mesh.vertices.len() as u32;
            sheet.mesh.vertices.extend([a, b, c]);
            sheet.mesh.triangles.push([first, first + 1, first + 2]);
            sheet.damage_time.extend(damage_time);
            sheet.front_speed.extend(front_speed);
        }
    }
    sheet
}
