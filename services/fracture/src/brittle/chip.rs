//! Chips off the rim of a contact: the cone crack that is finer than the grid.
//!
//! The tension at the rim of a Hertz contact is a tenth of its radius deep, and a grid of six cells
//! a radius is what it takes to see a cone crack leave it (H2). Where the rim tears on a coarser
//! grid and nothing parts, contact mechanics say how far the crack runs. It leaves the surface just
//! outside the contact, at 22° to it in glass \[Kocer and Collins 1998, from memory\], to a length
//! c with χ P = K c^{3/2}, as penny-like cracks of all indenters grow \[Lawn and Fuller 1975,
//! J. Mater. Sci. 10, 2016\]. Under a surface that curves away, or
//! near an edge, its straight way comes out again after a length L; past the middle of that the
//! glass above it only gets thinner, so a crack that comes so far runs out: the rim falls off in
//! flakes.

use super::Brittle;
use crate::mpm::load::ImpactLoad;
use cullet_fragment::cut::{CutError, CutPart, CutSettings, Partition, by_sites};
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::{Solid, Vec3};
use cullet_model::{BrittleProblem, Fragment, FragmentOrigin, Fragmentation, Material};

/// Cells a contact radius that show a cone crack (H2).
const CELLS: f64 = 6.0;
/// χ of the cone crack, K_Ic c^{3/2}/P \[1\]: finite elements of a half space with a crack at 22°
/// from a ring of c/10, the radius of the contact when it tears first; 0.040 at ν = 0.22, 0.037 at
/// 0.25, 0.032 at 0.3; from c/20 0.044, from c/5 0.032 (`tests/python/cone_crack.py`). The constant
/// that Roesler measured is in no source at hand.
const ROESLER: f64 = 0.040;
/// Sine and cosine of the angle between cone and surface.
const CONE: (f64, f64) = (0.3746, 0.9272);
/// Radius of the ring that the cone begins at, in contact radii (H2: 1.0 to 1.3).
const RING: f64 = 1.1;
/// Flakes around a contact: a cone's rim parts along radial cracks.
const FLAKES: u32 = 8;
/// Steps in which a way is followed.
const STEPS: u32 = 64;
/// Stream of the seed's numbers.
const STREAM: u64 = 0xc41b;

/// A crack that runs out: its way, and the middle between it and the surface.
struct Flake {
    /// Middles of the flake and of its mirror image in the crack, inside the body \[m\].
    sides: [Vec3; 2],
}

/// What falls off.
pub(super) struct Chips {
    pub(super) partition: Partition,
    /// Length of the cone crack \[m\].
    pub(super) length: f64,
}

/// Cuts off what cone cracks at these contacts separate; nothing if none comes out.
pub(super) fn chips(
    solid: &Solid,
    loads: &[&ImpactLoad],
    material: &Material,
    spacing: f64,
    settings: &CutSettings,
) -> Result<Option<Chips>, CutError> {
    let inside = Inside::new(&solid.mesh);
    let toughness = (material.young * material.fracture_energy).sqrt();
    let mut sites = vec![solid.mesh.mass_properties().centroid];
    let mut labels = vec![0];
    let mut longest = 0.0_f64;
    for (stream, load) in
        loads.iter().enumerate().filter(|(_, l)| spacing * CELLS > l.contact_radius())
    {
        // χ P = K c^{3/2}
        let length = libm::pow(ROESLER * load.peak() / toughness, 2.0 / 3.0);
        let turn = unit(settings.seed, STREAM, stream as u64);
        for k in 0..FLAKES {
            let angle = std::f64::consts::TAU * (f64::from(k) + turn) / f64::from(FLAKES);
            let Some(flake) = flake(&inside, load, angle, length) else {
                continue;
            };
            longest = longest.max(length);
            let label = labels.iter().max().map_or(0, |last| last + 1);
            sites.extend(flake.sides);
            labels.extend([label, 0]);
        }
    }
    if sites.len() == 1 {
        return Ok(None);
    }
    let times = vec![0.0; sites.len()];
    let partition = by_sites(solid, &sites, &labels, &times, settings)?;
    Ok((partition.parts.len() > 1).then_some(Chips { partition, length: longest }))
}

/// The flake at an angle about the axis of a contact, if a crack of this length comes half its way
/// out \[m\].
fn flake(inside: &Inside, load: &ImpactLoad, angle: f64, length: f64) -> Option<Flake> {
    let into = load.direction;
    let across = into
        .cross(&into.yzx())
        .try_normalize(1e-3)
        .or_else(|| into.cross(&Vec3::x()).try_normalize(1e-3))?;
    let (sin, cos) = libm::sincos(angle);
    let out = across * cos + into.cross(&across) * sin;
    let radius = RING * load.contact_radius();
    let surface = |from: f64| {
        let foot = load.point + out * from;
        // From outside down, as far as the surface may fall away.
        first(radius, |at| inside.contains(foot + into * (2.0 * at - radius)))
            .map(|at| foot + into * (2.0 * at - radius))
    };
    let ring = surface(radius)?;
    let along = (surface(1.2 * radius)? - surface(0.8 * radius)?).try_normalize(0.0)?;
    let inward = (into - along * into.dot(&along)).try_normalize(0.0)?;
    let flank = along * CONE.1 + inward * CONE.0;
    let skin = 0.02 * radius;
    let from = ring + flank * skin;
    let whole = first(2.0 * length, |at| !inside.contains(from + flank * at))? + skin;
    let middle = ring + flank * (0.5 * whole);
    let down = (inward - flank * inward.dot(&flank)).try_normalize(0.0)?;
    let depth = first(whole, |at| !inside.contains(middle - down * at))?;
    let half = down * (0.5 * depth);
    let sides = [middle - half, middle + half];
    sides.iter().all(|&side| inside.contains(side)).then_some(Flake { sides })
}

/// Where a condition first holds from 0 to `end` \[m\], to a part in a thousand of it.
fn first(end: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
    let step = end / f64::from(STEPS);
    let found = (0..=STEPS).find(|&k| holds(step * f64::from(k)))?;
    let (mut low, mut high) = (step * f64::from(found) - step, step * f64::from(found));
    if found == 0 {
        return Some(0.0);
    }
    for _ in 0..4 {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

/// Volume of what fell off, over the whole \[1\].
pub(super) fn share(parts: &[CutPart]) -> f64 {
    let whole: f64 = parts.iter().map(|part| part.volume).sum();
    let most = parts.iter().map(|part| part.volume).fold(0.0, f64::max);
    1.0 - most / whole
}

impl Brittle {
    /// A body in which the grid saw no crack, less what cone cracks too fine for it cut off.
    pub(super) fn chipped(&self, mut fracture: Fragmentation) -> Fragmentation {
        let torn = self.loads.iter().zip(&self.torn).filter(|(_, torn)| **torn);
        let torn: Vec<&ImpactLoad> = torn.map(|(load, _)| load).collect();
        // A crack that the grid has seen, though it parts nothing, has eased what drives a cone.
        let seen = fracture.fragments.first().is_none_or(|whole| !whole.sheet.is_empty());
        let parted = fracture.fragments.len() + fracture.debris.len() > 1;
        if torn.is_empty() || parted || seen {
            return fracture;
        }
        let BrittleProblem { solid, material, .. } = &self.problem;
        let spacing = self.domain.grid.spacing.max();
        let chips = match chips(solid, &torn, material, spacing, &self.cut_settings()) {
            Ok(Some(chips)) => chips,
            Ok(None) => return fracture,
            Err(error) => {
                fracture.report.warnings.push(format!("its chips could not be cut: {error}"));
                return fracture;
            }
        };
        let Chips { partition, length } = chips;
        let (flakes, share) = (partition.parts.len() - 1, share(&partition.parts));
        let whole = fracture.fragments.remove(0);
        let centre = solid.mesh.mass_properties().centroid;
        let piece = |part: CutPart| {
            let arm = part.solid.mesh.mass_properties().centroid - centre;
            let sheet = whole.sheet.clipped(&Inside::new(&part.solid.mesh));
            let (velocity, spin) = (whole.velocity + whole.spin.cross(&arm), whole.spin);
            Fragment { solid: part.solid, hulls: part.hulls, velocity, spin, sheet }
        };
        let most = partition.parts.iter().map(|part| part.volume).fold(0.0, f64::max);
        let origin = |part: &CutPart| FragmentOrigin::of_sampled(part.volume < most);
        fracture.origins = partition.parts.iter().map(origin).collect();
        fracture.fragments = partition.parts.into_iter().map(piece).collect();
        let report = &mut fracture.report;
        report.crack_area += partition.crack_area;
        report.fracture_energy = material.fracture_energy * report.crack_area;
        report.warnings.extend(partition.warnings);
        report.warnings.push(format!(
            "chipped: the rim of the contact tears and its cone crack runs {length:.3e} m, finer \
             than the grid; {flakes} flakes drawn there, {share:.3} of the body (H2)"
        ));
        fracture
    }
}
