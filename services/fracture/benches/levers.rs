//! What makes a solve shorter, and what that does to the outcome, as a table.
//!
//! `cargo bench -p cullet-fracture --bench levers > docs/bench/levers.csv` solves the first hits of
//! `scenes/column` and `scenes/threshold` for some seeds, in f64 and with one lever changed
//! each. `far` is how far the fragments' sizes are from those of the usual solve of
//! the same seed: the area between the two shares of mass below a size, sizes as powers of two;
//! in `seed` rows it is between one seed and the next.

use cullet_fracture::brittle::{Brittle, TerminationCriteria};
use cullet_fracture::mpm::Domain;
use cullet_fracture::mpm::stencil::vector;
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{
    BrittleProblem, Fragmentation, Impact, Material, PointPrecision, Progress, Settings, Solver,
    StrengthField, SurfaceLaw,
};
use cullet_simd::SimdLevel;
use std::sync::Arc;
use std::time::Instant;

/// Seeds of each row.
const SEEDS: u64 = 5;

/// Elements of a block of the kernel.
const BLOCK: usize = 64;

/// A steel ball of 25 m/s against the shaft of `scenes/column`.
fn column() -> BrittleProblem {
    let profile = [
        [0.0, 0.0],
        [0.16, 0.0],
        [0.16, 0.06],
        [0.12, 0.10],
        [0.105, 0.40],
        [0.11, 0.70],
        [0.16, 0.74],
        [0.16, 0.80],
        [0.0, 0.80],
    ];
    let mesh = shapes::lathe_solid(&profile, shapes::Detail::default()).expect("a column");
    let impact = Impact {
        point: Vec3::new(-0.10529, 0.00791, 0.07130),
        normal: Vec3::new(0.99973, 0.0, 0.02338).normalize(),
        impulse: 224.4,
        duration: 2.907e-4,
        radius: 1.0993e-2,
        energy: 2014.5,
        closing_speed: 25.0,
        crushing_pressure: 1e12,
    };
    let limestone = Material {
        density: 2790.0,
        young: 69e9,
        poisson: 0.29,
        failure_stress: 19.2e6,
        fracture_energy: 22.4,
    };
    problem(mesh.translated(-mesh.mass_properties().centroid), limestone, impact)
}

/// A plaster block of `scenes/threshold` that flies corner first against a wall at 8 m/s.
fn threshold() -> BrittleProblem {
    let mesh = shapes::cuboid(Vec3::repeat(0.14), shapes::Detail::default()).expect("a block");
    let impact = Impact {
        point: Vec3::new(0.07, -0.07, 0.07),
        normal: Vec3::new(-0.90767, 0.25882, -0.33037).normalize(),
        impulse: 24.29,
        duration: 6.131e-4,
        radius: 7.35e-3,
        energy: 47.21,
        closing_speed: 8.0,
        crushing_pressure: 1e12,
    };
    let plaster = Material {
        density: 1150.0,
        young: 4.5e9,
        poisson: 0.22,
        failure_stress: 2.5e6,
        fracture_energy: 4.1,
    };
    problem(mesh, plaster, impact)
}

fn problem(mesh: cullet_geometry::TriMesh, material: Material, impact: Impact) -> BrittleProblem {
    BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material,
        strength: StrengthField::default(),
        surface: SurfaceLaw::of(&material),
        impacts: vec![impact],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings { precision: PointPrecision::Double, ..Settings::default() },
        seed: 0,
    }
}

/// What came of a solve.
struct Outcome {
    fracture: Fragmentation,
    /// Seconds of the processor until the nodes stood still, and with the cut.
    solve: f64,
    whole: f64,
    /// Share of the steps before any damage.
    sound: f64,
    /// Share of the blocks' steps in which no node had moved at all, and by no more than a
    /// millionth of what breaks.
    still: [f64; 2],
}

fn cpu() -> f64 {
    let line = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    line.split(' ').next().and_then(|run| run.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1e-9
}

/// Shares of blocks in which displacements differ by nothing and by less than `faint` \[m\].
fn still(domain: &Domain, faint: f64) -> [f64; 2] {
    let blocks = domain.grid.elements.chunks(BLOCK);
    let (count, mut shares) = (blocks.len() as f64, [0.0; 2]);
    for block in blocks {
        let at = |node: u32| vector(domain.grid.nodes.displacement[node as usize]);
        let base = at(block[0].nodes[0]);
        let nodes = block.iter().flat_map(|element| &element.nodes);
        let most = nodes.map(|&node| (at(node) - base).amax()).fold(0.0, f64::max);
        shares[0] += f64::from(u8::from(most == 0.0)) / count;
        shares[1] += f64::from(u8::from(most < faint)) / count;
    }
    shares
}

fn solve(problem: &BrittleProblem, pace: TerminationCriteria) -> Outcome {
    let strain = problem.material.failure_stress / problem.material.young;
    let mut run = Brittle::with(problem.clone(), pace, SimdLevel::best()).expect("accepted");
    let (mut looks, mut sound, mut shares) = (0.0, 0.0, [0.0; 2]);
    let (mut solve, mut whole) = (0.0, 0.0);
    loop {
        let start = cpu();
        let progress = run.advance();
        whole += cpu() - start;
        match progress {
            Progress::Running(_) => {
                solve = whole;
                let domain = run.domain();
                looks += 1.0;
                sound += f64::from(u8::from(domain.particles.damage.iter().all(|&c| c <= 0.0)));
                let now = still(domain, 1e-6 * strain * domain.grid.spacing.max());
                shares = [shares[0] + now[0], shares[1] + now[1]];
            }
            Progress::Done(outcome) => {
                let fracture = outcome.fracture().expect("a fracture");
                let (sound, still) = (sound / looks, shares.map(|share| share / looks));
                return Outcome { fracture, solve, whole, sound, still };
            }
            Progress::Failed(failure) => panic!("{failure}"),
        }
    }
}

/// Fragments' shares of the body's volume, by size, with their cumulated sums.
fn sizes(fracture: &Fragmentation) -> Vec<(f64, f64)> {
    let volumes = fracture.fragments.iter().map(|f| f.solid.mesh.signed_volume());
    let mut volumes: Vec<f64> = volumes.chain(fracture.debris.iter().map(|g| g.volume)).collect();
    volumes.sort_by(f64::total_cmp);
    let whole: f64 = volumes.iter().sum();
    let mut below = 0.0;
    let shares = volumes.into_iter().map(|volume| {
        below += volume / whole;
        ((volume / whole).log2(), below)
    });
    shares.collect()
}

/// Area between two shares of mass below a size \[powers of two\].
fn far(a: &Fragmentation, b: &Fragmentation) -> f64 {
    let (a, b) = (sizes(a), sizes(b));
    let mut places: Vec<f64> = a.iter().chain(&b).map(|size| size.0).collect();
    places.sort_by(f64::total_cmp);
    let below = |sizes: &[(f64, f64)], x: f64| {
        let after = sizes.partition_point(|size| size.0 <= x);
        after.checked_sub(1).map_or(0.0, |at| sizes[at].1)
    };
    places.windows(2).map(|w| (w[1] - w[0]) * (below(&a, w[0]) - below(&b, w[0])).abs()).sum()
}

/// The levers: a name, a pace, and what becomes of the problem.
type Lever = (&'static str, TerminationCriteria, fn(&mut BrittleProblem));

fn levers() -> Vec<Lever> {
    let usual = TerminationCriteria::default();
    let none = |_: &mut BrittleProblem| ();
    vec![
        ("f32", usual, |problem| problem.settings.precision = PointPrecision::Single),
        ("no stop", TerminationCriteria { quiet: f64::INFINITY, ..usual }, none),
        ("quiet 1.5", TerminationCriteria { quiet: 1.5, ..usual }, none),
        ("push 1.5", TerminationCriteria { push: 1.5, ..usual }, none),
        ("push 12", TerminationCriteria { push: 12.0, ..usual }, none),
        ("half the points", usual, |problem| problem.settings.max_particles /= 2),
    ]
}

fn row(scene: &str, lever: &str, seed: u64, outcome: &Outcome, from: &Outcome, begun: Instant) {
    let Outcome { fracture, solve, whole, sound, still } = outcome;
    let report = &fracture.report;
    println!(
        "{scene},{lever},{seed},{},{solve:.3},{whole:.3},{},{:.4},{:.4},{:.3},{sound:.3},{:.3},\
         {:.3}",
        report.steps,
        fracture.fragments.len(),
        report.dissipated_energy,
        report.detail("delivered_impulse").unwrap_or_default(),
        far(fracture, &from.fracture),
        still[0],
        still[1],
    );
    eprintln!("{:.0} s", begun.elapsed().as_secs_f64());
}

fn main() {
    if !std::env::args().any(|arg| arg == "--bench") {
        return;
    }
    println!(
        "scene,lever,seed,steps,solve_cpu_s,cpu_s,fragments,dissipated_j,delivered_ns,far,\
         sound_share,still_share,faint_share"
    );
    let begun = Instant::now();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    pool.expect("a pool").install(|| {
        for (scene, base) in [("column", column()), ("threshold", threshold())] {
            let seeded = |seed: u64| {
                let strength = StrengthField { seed, ..base.strength.clone() };
                BrittleProblem { seed, strength, ..base.clone() }
            };
            let usual: Vec<Outcome> = (0..SEEDS)
                .map(|seed| solve(&seeded(seed), TerminationCriteria::default()))
                .collect();
            for (seed, outcome) in usual.iter().enumerate() {
                let next = &usual[(seed + 1) % usual.len()];
                row(scene, "seed", seed as u64, outcome, next, begun);
            }
            for (name, pace, change) in levers() {
                for (seed, usual) in (0..SEEDS).zip(&usual) {
                    let mut problem = seeded(seed);
                    change(&mut problem);
                    row(scene, name, seed, &solve(&problem, pace), usual, begun);
                }
            }
        }
    });
}
