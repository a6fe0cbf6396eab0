//! From a specimen to a sheet of points and bonds.

use super::outline::{AlignedSheet, unfit};
use crate::bending::FASTEST;
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use cullet_geometry::Vec3;
use cullet_model::strength::EVEN;
use cullet_model::{
    ContinuumBody, ContinuumSetup, MembraneLaw, MembraneMaterial, MembranePace, MembraneSheet,
    Refusal, SheetAir,
};
use cullet_specimen::{Notch, Probe, SpecimenProblem, Spot, Where, idle, within};

/// Horizon over the spacing where a specimen names none \[1\].
const HORIZON: f64 = 3.015;
/// Share of critical damping that bonds give their fastest motion: it goes with the square of a
/// motion's frequency.
const DASHPOTS: f64 = 0.02;
/// Spacings from the nearest point at which a probe still reads the body.
const FAR: f64 = 2.0;
/// Of a material that does not break, what a sheet asks for and never uses.
const UNUSED: (f64, f64) = (1e9, 1e12);

fn range(what: &'static str, value: f64, [low, high]: [f64; 2]) -> Result<(), Refusal> {
    let holds = (low..=high).contains(&value);
    if holds { Ok(()) } else { Err(Refusal::OutOfRange { what, value, low, high }) }
}

/// Refuses what cannot be solved, with the bound.
pub(super) fn check(specimen: &SpecimenProblem, shape: &AlignedSheet) -> Result<(), Refusal> {
    let (strength, s) = (&specimen.matter.strength, &specimen.settings);
    if let Some(plane) = strength.weak_plane {
        range("strength across a weak plane, of a sheet", plane.ratio, [1.0, 1.0])?;
    }
    if strength.layers.is_some() || (s.breaks && strength.weibull < EVEN) {
        return Err(unfit("the strength of a specimen's sheet is even".to_owned()));
    }
    let (what, limit) = ("the number of points", s.max_points);
    let value = specimen.body.mesh.signed_volume() / (shape.thickness * s.spacing * s.spacing);
    let over = value > limit;
    if over { Err(Refusal::TooLarge { what, value, limit }) } else { Ok(()) }
}

/// Horizon over the spacing \[1\].
pub(super) fn horizon(specimen: &SpecimenProblem) -> f64 {
    specimen.settings.horizon.unwrap_or(HORIZON)
}

/// The sheet's points and bonds.
pub(super) fn prepared(
    specimen: &SpecimenProblem,
    shape: &AlignedSheet,
) -> Result<PreparedMembrane, Refusal> {
    let (s, m) = (&specimen.settings, &specimen.matter.material);
    let (work, strength) = if s.breaks { (m.fracture_energy, m.failure_stress) } else { UNUSED };
    let sheet = MembraneSheet {
        outline: shape.outline.clone(),
        notches: Vec::new(),
        thickness: shape.thickness,
        spacing: s.spacing,
        horizon: horizon(specimen),
        material: MembraneMaterial {
            density: m.density,
            young: m.young,
            poisson: m.poisson,
            fracture_energy: work,
            strength,
            law: MembraneLaw::Brittle,
            scatter: 0.0,
            bending_floor: 0.0,
            damping: DASHPOTS,
        },
        pose: shape.pose,
        velocity: Vec3::zeros(),
        grips: Vec::new(),
        air: SheetAir {
            density: 0.0,
            drag: 0.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        },
        diffusion: Default::default(),
        foundation: None,
        pace: MembranePace::Real,
    };
    PreparedMembrane::new(&ContinuumSetup {
        body: ContinuumBody::Membrane(sheet),
        world_step: 1e-9,
        gravity: Vec3::zeros(),
        seed: s.seed,
    })
}

/// The longest stable step \[s\] where the greatest ω² of bending is `stiffer` times more.
pub(super) fn stable_step(prepared: &PreparedMembrane, stiffer: f64) -> f64 {
    let sheet = prepared.sheet();
    let squared = sheet.spacing * sheet.spacing;
    let by_area = sheet.material.density * sheet.thickness;
    let bending = FASTEST * prepared.bending / (by_area * squared * squared);
    let whole = 4.0 / (prepared.stable * prepared.stable) + stiffer * bending;
    2.0 / whole.sqrt()
}

/// Makes the whole run one step of the world, of as many steps as the run takes.
///
/// # Errors
/// If there are more than can be counted.
pub(super) fn choose_steps(
    specimen: &SpecimenProblem,
    prepared: &mut PreparedMembrane,
    stable_step: f64,
) -> Result<(), Refusal> {
    let end = specimen.output.end;
    let steps = (end / (specimen.settings.step_factor * stable_step)).ceil().max(1.0);
    range("the steps of a sheet", steps, [1.0, f64::from(u32::MAX)])?;
    (prepared.setup.world_step, prepared.substeps) = (end, steps as u32);
    Ok(())
}

/// The sheet as it starts, with its notches.
pub(super) fn started(
    specimen: &SpecimenProblem,
    prepared: &PreparedMembrane,
    rest: &[Vec3],
) -> Result<SheetState, Refusal> {
    taken(specimen, rest)?;
    let mut state = SheetState::start(prepared);
    let stretch = specimen.initial.stretch;
    for (i, x) in rest.iter().enumerate() {
        let starts = specimen.initial.starts.iter().filter(|start| within(&start.part, x, 0.0));
        state.velocities[i] = starts.map(|start| start.at(x, specimen.settings.seed)).sum();
        state.places[i] = x + stretch * x;
    }
    let slack = 1e-9 * specimen.settings.spacing;
    let mut cut = Vec::new();
    for notch in &specimen.initial.notches {
        let before = state.damage.iter().sum::<f64>();
        for (i, x) in rest.iter().enumerate() {
            for b in prepared.bonds.of(i) {
                if crosses(notch, [x, &rest[prepared.bonds.ends[b] as usize]], slack) {
                    state.damage[b] = 1.0;
                }
            }
        }
        cut.push(state.damage.iter().sum::<f64>() == before);
    }
    idle("notch", cut.into_iter())?;
    Ok(state)
}

/// Refuses starts and places of probes that take none of the points.
fn taken(specimen: &SpecimenProblem, rest: &[Vec3]) -> Result<(), Refusal> {
    let none = |part: &Where| !rest.iter().any(|x| within(part, x, 0.0));
    let starts = specimen.initial.starts.iter();
    idle("start", starts.map(|start| !start.is_none() && none(&start.part)))?;
    let near = FAR * specimen.settings.spacing;
    let away = |probe: &Probe| match probe {
        Probe::Points(_, _, Spot::At(x)) => !rest.iter().any(|at| (at - x).norm() <= near),
        _ => false,
    };
    idle("probe", specimen.output.probes.iter().map(away))
}

/// Whether a notch lies between two places, whichever comes first.
fn crosses(notch: &Notch, [a, b]: [&Vec3; 2], slack: f64) -> bool {
    let [first, second] = [a, b].map(|x| (x - notch.point).dot(&notch.normal));
    if (first >= 0.0) == (second >= 0.0) {
        return false;
    }
    // From the same end, whichever asks.
    let (x, y, at, to) = match first > second {
        true => (a, b, first, second),
        false => (b, a, second, first),
    };
    within(&notch.part, &(x + (y - x) * (at / (at - to))), slack)
}
