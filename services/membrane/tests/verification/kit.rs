//! Sheets of these tests, how they move, and what is measured of them.

use cullet_geometry::{Pose, Vec3};
use cullet_membrane::{MembraneWindow, PreparedMembrane, SheetState};
use cullet_model::{
    Continuum, ContinuumBody, ContinuumSetup, MembraneLaw, MembraneMaterial, MembranePace,
    MembraneSheet, SheetAir, SheetDiffusion, SheetGrip, SheetPlace, SheetRegion, SheetSource,
    SheetSourceKind, Window, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// An elastic sheet of 1 MPa and 1 mm between two corners, in a vacuum, with points this far apart.
pub(crate) fn sheet(low: SheetPlace, high: SheetPlace, spacing: f64) -> MembraneSheet {
    MembraneSheet {
        outline: vec![low, [high[0], low[1]], high, [low[0], high[1]]],
        notches: vec![],
        thickness: 1e-3,
        spacing,
        horizon: 3.015,
        material: MembraneMaterial {
            density: 1000.0,
            young: 1e6,
            poisson: 1.0 / 3.0,
            fracture_energy: 10.0,
            strength: 1e12,
            law: MembraneLaw::Brittle,
            scatter: 0.0,
            bending_floor: 0.0,
            damping: 0.02,
        },
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        grips: vec![],
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
    }
}

/// The sheet in a world without gravity.
pub(crate) fn setup(sheet: MembraneSheet, world_step: f64, seed: u64) -> ContinuumSetup {
    let (body, gravity) = (ContinuumBody::Membrane(sheet), Vec3::zeros());
    ContinuumSetup { body, world_step, gravity, seed }
}

pub(crate) fn prepare(setup: &ContinuumSetup) -> Arc<PreparedMembrane> {
    Arc::new(PreparedMembrane::new(setup).unwrap())
}

/// A grip on a box.
pub(crate) fn grip(low: SheetPlace, high: SheetPlace, path: Vec<(f64, Vec3)>) -> SheetGrip {
    SheetGrip { region: SheetRegion::Box { low, high }, path, until: None }
}

/// What changes all of a sheet alike, or spreads in it, with no source yet.
pub(crate) fn quantity(expansion: f64, diffusivity: f64) -> SheetDiffusion {
    SheetDiffusion {
        capacity: 1.0,
        conductivity: [diffusivity; 2],
        expansion: [expansion; 2],
        start: 0.0,
        saturation: f64::INFINITY,
        stiffness: vec![],
        toughness: vec![],
        strength: vec![],
        exposure: 0.0,
        weight: 0.0,
        loss: 0.0,
        ambient: 0.0,
        sources: vec![],
    }
}

/// Sources that hold a region at a value which goes to `last` in even stairs \[s\].
pub(crate) fn stairs(region: SheetRegion, last: f64, rise: f64, count: u32) -> Vec<SheetSource> {
    let stair = |k: u32| {
        let share = |k: u32| f64::from(k) / f64::from(count);
        SheetSource {
            region,
            from: rise * share(k),
            until: if k + 1 == count { f64::INFINITY } else { rise * share(k + 1) },
            kind: SheetSourceKind::Held(last * share(k + 1)),
        }
    };
    (0..count).map(stair).collect()
}

/// Solves some steps of the world.
pub(crate) fn solve(
    prepared: &Arc<PreparedMembrane>,
    state: &SheetState,
    steps: u32,
) -> (Box<WindowOutcome>, SheetState) {
    let bytes = state.encode(prepared);
    let window =
        Window { first_step: state.step, steps, frame_every: 0, proxies: vec![], retired: None };
    let mut run = MembraneWindow::open(Arc::clone(prepared), Some(&bytes), window).unwrap();
    loop {
        match Continuum::advance(&mut run) {
            WindowProgress::Running(_) => {}
            WindowProgress::Done(outcome) => return (outcome, run.state().clone()),
            WindowProgress::Failed(failure) => panic!("{failure}"),
        }
    }
}

/// Steps a sheet until it rests, at most so many steps of the world; its energy \[J\]. Velocities
/// are taken away whenever the kinetic energy has passed its peak.
pub(crate) fn settled(
    prepared: &Arc<PreparedMembrane>,
    mut state: SheetState,
    most: u32,
) -> (SheetState, f64) {
    let (mut kinetic, mut energy) = (0.0, 0.0);
    for _ in 0..most {
        let (outcome, mut next) = solve(prepared, &state, 1);
        if outcome.ledger.kinetic < kinetic {
            next.velocities.iter_mut().for_each(|v| *v = Vec3::zeros());
            kinetic = 0.0;
        } else {
            kinetic = outcome.ledger.kinetic;
        }
        energy = outcome.ledger.stretching + outcome.ledger.bending;
        state = next;
        if kinetic > 0.0 && kinetic < 1e-10 * energy {
            break;
        }
    }
    state.velocities.iter_mut().for_each(|v| *v = Vec3::zeros());
    state.step = 0;
    (state, energy)
}

/// Where bonds that no notch cut have broken: the middle of each, at rest.
pub(crate) fn cracks(prepared: &PreparedMembrane, state: &SheetState) -> Vec<SheetPlace> {
    let (places, bonds) = (&prepared.points.places, &prepared.bonds);
    let mut found = Vec::new();
    for (i, p) in places.iter().enumerate() {
        for b in bonds.of(i).filter(|&b| state.damage[b] >= 1.0 && !bonds.cut[b]) {
            let q = places[bonds.ends[b] as usize];
            if (bonds.ends[b] as usize) > i {
                found.push([0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]);
            }
        }
    }
    found
}

/// Mean and greatest of some numbers.
pub(crate) fn mean_and_most(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// Seeds from 1 on: so few, or as many as `CULLET_SEEDS` says.
pub(crate) fn seeds(few: u64) -> std::ops::RangeInclusive<u64> {
    let wanted = std::env::var("CULLET_SEEDS").ok().and_then(|text| text.parse().ok());
    1..=wanted.unwrap_or(few)
}
