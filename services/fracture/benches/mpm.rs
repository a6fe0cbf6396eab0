//! Particle-steps a second of the full step, damage on: items are particle-steps.
//!
//! `cargo bench -p cullet-fracture --bench mpm` runs divan; with `-- --csv` it writes a table, each
//! row with the time that the processor gave to it and the calibration loops of the same moment;
//! `=WORDS` keeps the rows that have them.

use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::Domain;
use cullet_fracture::particles::Particles;
use cullet_geometry::{Vec3, math::unit};
use cullet_model::{Material, PointPrecision};
use cullet_simd::SimdLevel;
use divan::Bencher;
use divan::counter::ItemsCount;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

/// Numbers of points.
const COUNTS: [usize; 3] = [17_576, 140_608, 1_061_208];

/// What a cube goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// It turns and stretches, and nothing breaks.
    Intact,
    /// Likewise, with a parted layer of broken points in every sixth cell.
    Cracked,
    /// It is pulled until cracks run everywhere.
    Breaking,
}

/// What is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Case {
    count: usize,
    state: State,
    precision: PointPrecision,
    path: usize,
    threads: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, state, precision, threads, .. } = self;
        write!(f, "{count} {state:?} {precision:?} {} {threads}", SimdLevel::all()[self.path])
    }
}

/// Every precision and number of threads on the best path, and the other paths at one size.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for count in COUNTS {
        for state in [State::Intact, State::Cracked] {
            for precision in [PointPrecision::Single, PointPrecision::Double] {
                for threads in [1, 2] {
                    cases.push(Case { count, state, precision, path: 0, threads });
                }
            }
        }
    }
    let base = cases[8];
    for precision in [PointPrecision::Single, PointPrecision::Double] {
        cases.push(Case { state: State::Breaking, precision, ..base });
    }
    for path in 1..SimdLevel::all().len() {
        for precision in [PointPrecision::Single, PointPrecision::Double] {
            cases.push(Case { path, precision, ..base });
        }
    }
    cases
}

fn main() {
    if std::env::args().any(|arg| arg == "--csv") {
        table();
    } else {
        divan::main();
    }
}

/// A cube of about `count` points, 8 to a cell in the mean.
fn cube(case: &Case) -> Domain {
    let side = (1..).find(|n| n * n * n >= case.count).unwrap_or(1);
    let pitch = 0.2 / side as f64;
    let spacing = 2.0 * pitch;
    let stone = Material {
        density: 2300.0,
        young: 40e9,
        poisson: 0.2,
        failure_stress: 30e6,
        fracture_energy: 25.0,
    };
    let points: Vec<Vec3> = (0..side * side * side)
        .map(|i| {
            let cell = [i / (side * side), i / side % side, i % side];
            // Off the cells' own faces, so that 1 to 20 points share a cell.
            Vec3::from([0, 1, 2].map(|a| {
                let jitter = unit(1, a as u64, i as u64);
                (cell[a] as f64 + jitter - 0.5 * side as f64 + 0.35) * pitch
            }))
        })
        .collect();
    let mut particles = Particles::at_rest(&points, 0.008, stone.density);
    let cracked = case.state == State::Cracked;
    let layer = |x: &Vec3| (x.x / spacing).rem_euclid(6.0);
    for (p, x) in points.iter().enumerate() {
        particles.strength[p] = 0.8 + 0.4 * unit(2, 0, p as u64);
        particles.damage[p] = f64::from(u8::from(cracked && layer(x) < 1.0));
    }
    let law = Softening::on_grid(&stone, spacing);
    let mut domain = Domain::new(particles, &stone, law, Vec3::repeat(spacing));
    domain.select(case.precision, SimdLevel::all()[case.path]);
    let spin = Vec3::new(3.0, -2.0, 4.0);
    domain.launch(|x| spin.cross(x) + Vec3::new(0.3 * x.x, -0.1 * x.y, 0.2 * x.z));
    if cracked {
        let side = |x: &Vec3| (x.x / spacing - 0.5).div_euclid(6.0);
        domain.sever(|a, b| side(a) != side(b));
    }
    if case.state == State::Breaking {
        // To break within thirty steps.
        let rate = stone.failure_stress / stone.young / (30.0 * domain.step);
        domain.launch(|x| Vec3::new(x.x, 0.5 * x.y, 0.2 * x.z) * rate);
    }
    domain.advance();
    domain
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool")
}

/// Seconds of each of `rounds` calls.
fn times(rounds: usize, mut call: impl FnMut()) -> Vec<f64> {
    (0..rounds)
        .map(|_| {
            let start = Instant::now();
            call();
            start.elapsed().as_secs_f64()
        })
        .collect()
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
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

/// Sixteen million multiplications and additions, in registers; returns GFLOP/s.
fn calibrate_flops() -> f64 {
    let mut time = times(9, || {
        let mut lanes = [[1.0_f32; 16]; 8];
        for _ in 0..62_500 {
            for lane in lanes.as_flattened_mut() {
                *lane = *lane * 0.999 + 0.001;
            }
        }
        black_box(lanes);
    });
    16e6 / median(&mut time) * 1e-9
}

/// a = b + s c over 96 MB; returns GB/s.
fn calibrate_triad(arrays: &mut [Vec<f64>; 3]) -> f64 {
    let [a, b, c] = arrays;
    let mut time = times(5, || {
        for ((a, b), c) in a.iter_mut().zip(&*b).zip(&*c) {
            *a = b + 3.0 * c;
        }
        black_box(&a);
    });
    24.0 * a.len() as f64 / median(&mut time) * 1e-9
}

fn table() {
    let mut arrays = [vec![0.0; 4_000_000], vec![1.0; 4_000_000], vec![2.0; 4_000_000]];
    println!(
        "points,state,precision,path,threads,median_ns,least_ns,cpu_ns,median_million_per_s,\
         calibration_gflops,calibration_gb_per_s"
    );
    let only: Vec<String> = std::env::args().filter(|arg| arg.starts_with('=')).collect();
    let asked = |case: &Case| only.iter().all(|o| case.to_string().contains(&o[1..]));
    for case in cases().iter().filter(|case| asked(case)) {
        let mut domain = cube(case);
        let n = domain.particles.len() as f64;
        let rounds = (20_000_000 / domain.particles.len()).clamp(25, 1000);
        let pool = pool(case.threads);
        let before = cpu();
        let mut time = pool.install(|| {
            times(rounds, || {
                black_box(domain.advance());
            })
        });
        let cpu = (cpu() - before) / rounds as f64;
        let median = median(&mut time);
        println!(
            "{},{:.1},{:.1},{:.1},{:.1},{:.1},{:.1}",
            case.to_string().replace(' ', ","),
            median / n * 1e9,
            time[0] / n * 1e9,
            cpu / n * 1e9,
            n / median * 1e-6,
            calibrate_flops(),
            calibrate_triad(&mut arrays)
        );
    }
}

#[divan::bench(args = cases(), sample_count = 10, sample_size = 1)]
fn ten_steps(bencher: Bencher<'_, '_>, case: &Case) {
    let mut domain = cube(case);
    let pool = pool(case.threads);
    let items = domain.particles.len() * 10;
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        pool.install(|| {
            (0..10).for_each(|_| {
                black_box(domain.advance());
            });
        });
    });
}

#[divan::bench]
fn calibration_flops() -> f64 {
    calibrate_flops()
}
