//! Particle-steps a second of whole windows: items are points times steps.
//!
//! `cargo bench -p cullet-membrane --bench steps`.

use cullet_geometry::{Pose, Vec3};
use cullet_membrane::{MembraneWindow, PreparedMembrane};
use cullet_model::{
    Continuum, ContinuumBody, ContinuumSetup, MembraneLaw, MembraneMaterial, MembranePace,
    MembraneSheet, SheetAir, Window, WindowProgress,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use std::fmt;
use std::sync::Arc;

/// What is timed: a free sheet with an initial stretch that swings.
#[derive(Clone, Copy, Debug)]
struct Case {
    law: MembraneLaw,
    /// Points along an edge of the square.
    edge: u32,
    poisson: f64,
    bends: bool,
    threads: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { law, edge, poisson, bends, threads } = self;
        let points = edge * edge;
        let bending = if *bends { "bending" } else { "flat" };
        write!(f, "{law:?} {points} points, nu {poisson:.2}, {bending}, {threads}")
    }
}

fn cases() -> Vec<Case> {
    let third = 1.0 / 3.0;
    let base =
        Case { law: MembraneLaw::Brittle, edge: 50, poisson: third, bends: true, threads: 1 };
    vec![
        Case { bends: false, ..base },
        base,
        Case { threads: 2, ..base },
        Case { poisson: 0.2, ..base },
        Case { law: MembraneLaw::Foil, ..base },
        Case { law: MembraneLaw::Rubber, ..base },
        Case { edge: 100, ..base },
        Case { edge: 100, threads: 2, ..base },
    ]
}

fn main() {
    divan::main();
}

fn sheet(case: &Case) -> ContinuumSetup {
    let side = 0.2;
    let spacing = side / f64::from(case.edge);
    let sheet = MembraneSheet {
        outline: vec![[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]],
        notches: vec![],
        thickness: 2e-4,
        spacing,
        horizon: 3.015,
        material: MembraneMaterial {
            density: 800.0,
            young: 1e6,
            poisson: case.poisson,
            fracture_energy: 1e3,
            strength: 1e9,
            law: case.law,
            scatter: 0.0,
            bending_floor: 0.3 * f64::from(u8::from(case.bends)),
            damping: 0.1,
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
        diffusion: None,
        pace: MembranePace::Real,
    };
    ContinuumSetup {
        body: ContinuumBody::Membrane(sheet),
        world_step: 1.0 / 240.0,
        gravity: Vec3::new(0.0, 0.0, -9.81),
        seed: 1,
    }
}

/// One step of the world.
#[divan::bench(args = cases(), sample_count = 10, sample_size = 1)]
fn steps(bencher: Bencher<'_, '_>, case: &Case) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(case.threads).build().expect("a pool");
    let prepared = Arc::new(PreparedMembrane::new(&sheet(case)).expect("a sheet"));
    let items = prepared.points.places.len() as u64 * u64::from(prepared.substeps);
    let window = Window { first_step: 0, steps: 1, frame_every: 0, proxies: vec![] };
    bencher
        .counter(ItemsCount::new(items))
        .with_inputs(|| {
            MembraneWindow::open(Arc::clone(&prepared), None, window.clone()).expect("a window")
        })
        .bench_local_values(|mut run| {
            pool.install(|| {
                while matches!(Continuum::advance(&mut run), WindowProgress::Running(_)) {}
            });
        });
}
