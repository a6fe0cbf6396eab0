//! Sheets for tests.

use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::steps::SheetRun;
use crate::window::MembraneWindow;
use cullet_geometry::{Pose, Vec3};
use cullet_model::{
    Continuum, ContinuumBody, ContinuumSetup, MembraneLaw, MembraneMaterial, MembranePace,
    MembraneSheet, SheetAir, SheetDiffusion, SheetGrip, SheetRegion, SheetSource, SheetSourceKind,
    Window, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// A sheet of 0.2 × 0.1 m that nothing holds and nothing moves.
pub(crate) fn setup() -> ContinuumSetup {
    let sheet = MembraneSheet {
        outline: vec![[0.0, 0.0], [0.2, 0.0], [0.2, 0.1], [0.0, 0.1]],
        notches: vec![],
        thickness: 1e-3,
        spacing: 5e-3,
        horizon: 3.015,
        material: MembraneMaterial {
            density: 1000.0,
            young: 1e6,
            poisson: 1.0 / 3.0,
            fracture_energy: 1e3,
            strength: 1e9,
            law: MembraneLaw::Brittle,
            scatter: 0.0,
            bending_floor: 0.0,
            damping: 0.1,
        },
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        grips: vec![],
        air: SheetAir {
            density: 0.0,
            drag: 1.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        },
        diffusion: Default::default(),
        foundation: None,
        pace: MembranePace::Real,
    };
    ContinuumSetup {
        body: ContinuumBody::Membrane(sheet),
        world_step: 1.0 / 240.0,
        gravity: Vec3::zeros(),
        seed: 1,
    }
}

/// Changes the sheet of a set-up.
pub(crate) fn with(
    mut setup: ContinuumSetup,
    f: impl FnOnce(&mut MembraneSheet),
) -> ContinuumSetup {
    if let ContinuumBody::Membrane(sheet) = &mut setup.body {
        f(sheet);
    }
    setup
}

/// A grip on a box, led along a path.
pub(crate) fn grip(low: [f64; 2], high: [f64; 2], path: Vec<(f64, Vec3)>) -> SheetGrip {
    SheetGrip { region: SheetRegion::Box { low, high }, path, until: None }
}

/// A window of some steps without bodies.
pub(crate) fn window(first_step: u64, steps: u32) -> Window {
    Window { first_step, steps, frame_every: 0, proxies: vec![], retired: None }
}

/// Solves a window.
pub(crate) fn solve(
    prepared: &Arc<PreparedMembrane>,
    state: Option<&[u8]>,
    window: Window,
) -> Box<WindowOutcome> {
    let mut run = MembraneWindow::open(Arc::clone(prepared), state, window).unwrap();
    loop {
        match Continuum::advance(&mut run) {
            WindowProgress::Running(_) => {}
            WindowProgress::Done(outcome) => return outcome,
            WindowProgress::Failed(failure) => panic!("{failure}"),
        }
    }
}

/// A run from a state; from rest without one.
pub(crate) fn begun(setup: &ContinuumSetup, change: impl FnOnce(&mut SheetState)) -> SheetRun {
    let prepared = Arc::new(PreparedMembrane::new(setup).unwrap());
    let mut state = SheetState::start(&prepared);
    change(&mut state);
    SheetRun::new(prepared, state, vec![])
}

/// Solves a window of some steps from a changed start.
pub(crate) fn solve_from(
    setup: &ContinuumSetup,
    steps: u32,
    change: impl FnOnce(&mut SheetState),
) -> Box<WindowOutcome> {
    let prepared = Arc::new(PreparedMembrane::new(setup).unwrap());
    let mut state = SheetState::start(&prepared);
    change(&mut state);
    let bytes = state.encode(&prepared);
    solve(&prepared, Some(&bytes), window(0, steps))
}

/// A figure of an outcome.
pub(crate) fn figure(outcome: &WindowOutcome, name: &str) -> f64 {
    outcome.figures.iter().find(|figure| figure.name == name).expect("the figure").value
}

/// Whether an outcome has a warning with these words.
pub(crate) fn warns(outcome: &WindowOutcome, words: &str) -> bool {
    outcome.warnings.iter().any(|warning| warning.contains(words))
}

/// Something that spreads and does nothing, from these sources.
pub(crate) fn harmless(sources: Vec<(SheetRegion, SheetSourceKind)>) -> SheetDiffusion {
    let source = |(region, kind)| SheetSource { region, from: 0.0, until: f64::INFINITY, kind };
    SheetDiffusion {
        capacity: 1.0,
        conductivity: [1e-5; 2],
        expansion: [0.0; 2],
        start: 0.0,
        saturation: f64::INFINITY,
        stiffness: vec![],
        toughness: vec![],
        strength: vec![],
        exposure: 0.0,
        weight: 0.0,
        loss: 0.0,
        ambient: 0.0,
        sources: sources.into_iter().map(source).collect(),
    }
}

mod elastic;
mod foundations;
mod motion;
mod quantities;
mod tears;
