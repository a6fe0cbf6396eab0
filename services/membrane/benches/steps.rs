//! Particle-steps a second of whole windows: items are points times steps. A point has 27 to 28
//! bonds, fewer at edges, and bends by 15 of them. `paper_sizes` takes 20 steps of sheets with
//! the numbers of Han and others' Table 1.
//!
//! `cargo bench -p cullet-membrane --bench steps` times windows of one step of the world, their end
//! included. With `-- --csv` it writes a table instead, of slices of a window as a worker takes
//! them: nanoseconds for one point in one step, and processor time. `=` and a text choose rows.

use cullet_geometry::{Pose, Vec3};
use cullet_membrane::{MembraneWindow, PreparedMembrane, SheetState};
use cullet_model::{
    Continuum, ContinuumBody, ContinuumSetup, MembraneLaw, MembraneMaterial, MembranePace,
    MembraneSheet, SheetAir, SheetDiffusion, Window, WindowProgress,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use std::fmt;
use std::sync::Arc;
use std::time::Instant;

/// What is timed: a free sheet with an initial stretch that swings.
#[derive(Clone, Copy, Debug)]
struct Case {
    law: MembraneLaw,
    /// Points along an edge of the square.
    edge: u32,
    poisson: f64,
    /// Whether there is air.
    blows: bool,
    /// One bond of this many is damaged.
    damaged: Option<usize>,
    threads: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { law, edge, poisson, blows, damaged, threads } = self;
        let points = edge * edge;
        let air = if *blows { ", air" } else { "" };
        let touched = damaged.map(|n| format!(", 1 of {n} damaged")).unwrap_or_default();
        write!(f, "{law:?} {points} points, nu {poisson:.2}{air}{touched}, {threads}")
    }
}

fn cases() -> Vec<Case> {
    let whole = Case {
        law: MembraneLaw::Brittle,
        edge: 50,
        poisson: 1.0 / 3.0,
        blows: false,
        damaged: None,
        threads: 1,
    };
    let one = vec![
        whole,
        Case { law: MembraneLaw::Foil, ..whole },
        Case { law: MembraneLaw::Rubber, ..whole },
        Case { poisson: 0.2, ..whole },
        Case { blows: true, ..whole },
        Case { damaged: Some(100), ..whole },
        Case { edge: 100, ..whole },
    ];
    let two: Vec<Case> = one.iter().map(|case| Case { threads: 2, ..*case }).collect();
    [one, two].concat()
}

fn main() {
    match std::env::args().any(|arg| arg == "--csv") {
        true => table(),
        false => divan::main(),
    }
}

/// Seconds that the threads of this process have run, or not a number where that is unknown.
fn cpu() -> f64 {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else {
        return f64::NAN;
    };
    let run = tasks.flatten().map(|task| {
        let line = std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
        line.split(' ').next().and_then(|run| run.parse::<f64>().ok()).unwrap_or(f64::NAN)
    });
    run.sum::<f64>() * 1e-9
}

/// One row for each case. What follows `=` on the command line chooses those whose names have it.
fn table() {
    println!(
        "case,points,bonds,median_ns,least_ns,cpu_ns,million_points_per_cpu_s,\
         million_bonds_per_cpu_s"
    );
    let only: Vec<String> = std::env::args().filter(|arg| arg.starts_with('=')).collect();
    let asked = |case: &Case| only.iter().all(|o| case.to_string().contains(&o[1..]));
    for case in cases().iter().filter(|case| asked(case)) {
        let prepared = Arc::new(PreparedMembrane::new(&sheet(case)).expect("a sheet"));
        let (points, bonds) =
            (prepared.points.places.len() as f64, prepared.bonds.ends.len() as f64);
        let steps = (4e6 / (points * f64::from(prepared.substeps))).ceil() as u32;
        let window =
            Window { first_step: 0, steps, frame_every: 0, proxies: vec![], retired: None };
        let state = case.damaged.map(|every| damaged(&prepared, every));
        let mut run = MembraneWindow::open(Arc::clone(&prepared), state.as_deref(), window)
            .expect("a window");
        let pool = pool(case.threads);
        let all = f64::from(steps) * f64::from(prepared.substeps) * points;
        let (mut times, mut last, first) = (Vec::new(), 0.0, cpu());
        let mut spent = first;
        // The slice that closes the window is left out.
        loop {
            let start = Instant::now();
            let WindowProgress::Running(come) = pool.install(|| Continuum::advance(&mut run))
            else {
                break;
            };
            times.push(start.elapsed().as_secs_f64() / (all * (come - last)));
            (last, spent) = (come, cpu());
        }
        times.sort_by(f64::total_cmp);
        let each = (spent - first) / (all * last);
        println!(
            "{},{points},{bonds},{:.1},{:.1},{:.1},{:.2},{:.0}",
            case.to_string().replace(", ", " "),
            times[times.len() / 2] * 1e9,
            times[0] * 1e9,
            each * 1e9,
            1e-6 / each,
            1e-6 / each * bonds / points,
        );
    }
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool")
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
            bending_floor: 0.3,
            damping: 0.1,
        },
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        grips: vec![],
        air: SheetAir {
            density: if case.blows { 1.2 } else { 0.0 },
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
        gravity: Vec3::new(0.0, 0.0, -9.81),
        seed: 1,
    }
}

/// A sheet of which some bonds are damaged.
fn damaged(prepared: &PreparedMembrane, every: usize) -> Vec<u8> {
    let mut state = SheetState::start(prepared);
    let bonds = &prepared.bonds;
    for i in 0..prepared.points.places.len() {
        for b in bonds.of(i).filter(|&b| bonds.ends[b] as usize > i) {
            if (b * 7919) % every == 0 {
                [state.damage[b], state.damage[bonds.twins[b] as usize]] = [0.5; 2];
            }
        }
    }
    state.encode(prepared)
}

/// One step of the world.
#[divan::bench(args = cases(), sample_count = 10, sample_size = 1)]
fn steps(bencher: Bencher<'_, '_>, case: &Case) {
    let pool = pool(case.threads);
    let prepared = Arc::new(PreparedMembrane::new(&sheet(case)).expect("a sheet"));
    let items = prepared.points.places.len() as u64 * u64::from(prepared.substeps);
    let window = Window { first_step: 0, steps: 1, frame_every: 0, proxies: vec![], retired: None };
    let state = case.damaged.map(|every| damaged(&prepared, every));
    bencher
        .counter(ItemsCount::new(items))
        .with_inputs(|| {
            MembraneWindow::open(Arc::clone(&prepared), state.as_deref(), window.clone())
                .expect("a window")
        })
        .bench_local_values(|mut run| {
            pool.install(|| {
                while matches!(Continuum::advance(&mut run), WindowProgress::Running(_)) {}
            });
        });
}

/// A row of the table: what the paper says of its sheet.
#[derive(Clone, Copy, Debug)]
struct PaperRow {
    name: &'static str,
    law: MembraneLaw,
    young: f64,
    density: f64,
    spacing: f64,
    /// Of k and α, where something spreads.
    spreads: Option<[f64; 2]>,
    fracture_energy: f64,
}

const PAPER: [PaperRow; 5] = [
    PaperRow {
        name: "stretch, shear",
        law: MembraneLaw::Brittle,
        young: 2e4,
        density: 5000.0,
        spacing: 0.02,
        spreads: None,
        fracture_energy: 1e6,
    },
    PaperRow {
        name: "crack path",
        law: MembraneLaw::Brittle,
        young: 2e4,
        density: 5000.0,
        spacing: 0.02,
        spreads: Some([0.01, 1.0]),
        fracture_energy: 11.3,
    },
    PaperRow {
        name: "foil",
        law: MembraneLaw::Foil,
        young: 2e3,
        density: 5000.0,
        spacing: 0.04,
        spreads: Some([0.3, 0.3]),
        fracture_energy: 1.2,
    },
    PaperRow {
        name: "rubbery film",
        law: MembraneLaw::Rubber,
        young: 1e2,
        density: 100.0,
        spacing: 0.04,
        spreads: Some([1.0, 10.0]),
        fracture_energy: 11.3,
    },
    PaperRow {
        name: "seaweed",
        law: MembraneLaw::Brittle,
        young: 2e4,
        density: 100.0,
        spacing: 0.04,
        spreads: Some([0.01, 0.3]),
        fracture_energy: 2.4,
    },
];

/// The sheet of a row, 2 m wide, with a step of the world that is 20 of its own.
fn paper_sheet(row: &PaperRow) -> PreparedMembrane {
    let base = sheet(&Case { law: row.law, poisson: 0.3, ..cases()[1] });
    let ContinuumBody::Membrane(mut own) = base.body.clone() else {
        unreachable!("it was made as a sheet")
    };
    own.outline = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    own.spacing = row.spacing;
    own.thickness = 1e-3;
    own.material.young = row.young;
    own.material.density = row.density;
    own.material.fracture_energy = row.fracture_energy;
    own.material.strength = 0.1 * row.young;
    own.diffusion = row
        .spreads
        .map(|[k, alpha]| SheetDiffusion {
            capacity: row.density,
            conductivity: [k; 2],
            expansion: [alpha; 2],
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
        })
        .into();
    let setup = |world_step: f64| ContinuumSetup {
        body: ContinuumBody::Membrane(own.clone()),
        world_step,
        ..base.clone()
    };
    let long = PreparedMembrane::new(&setup(1e-3)).expect("a sheet");
    let world_step = 20.0 * 0.4 * long.stable * (1.0 - 1e-9);
    PreparedMembrane::new(&setup(world_step)).expect("a sheet")
}

impl fmt::Display for PaperRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let prepared = paper_sheet(self);
        let (points, step) = (prepared.points.places.len(), prepared.step());
        write!(f, "{}: {points} points, {step:.2e} s", self.name)
    }
}

/// Twenty steps.
#[divan::bench(args = PAPER, sample_count = 10, sample_size = 1)]
fn paper_sizes(bencher: Bencher<'_, '_>, row: &PaperRow) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let prepared = Arc::new(paper_sheet(row));
    let items = prepared.points.places.len() as u64 * u64::from(prepared.substeps);
    let window = Window { first_step: 0, steps: 1, frame_every: 0, proxies: vec![], retired: None };
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
