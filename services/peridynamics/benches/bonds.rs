//! Bond-steps a second of a whole step, both passes: items are bonds, each counted at both of its
//! ends, times steps.
//!
//! `cargo bench -p cullet-peridynamics --bench bonds`.

use cullet_geometry::Vec3;
use cullet_model::Hardening;
use cullet_peridynamics::law::BondBreaking;
use cullet_peridynamics::{PeridynamicDomain, PeridynamicLaw};
use cullet_simd::SimdLevel;
use divan::Bencher;
use divan::counter::ItemsCount;
use std::fmt;

/// What a body does.
#[derive(Clone, Copy, Debug)]
enum Does {
    /// It swings.
    Swings,
    /// It may yield, and does not.
    MayYield,
    /// All of it yields in every step.
    Yields,
    /// It may yield and break, and yields.
    MayBreak,
}

/// What is timed.
#[derive(Clone, Copy, Debug)]
struct Case {
    does: Does,
    /// Points along an edge of the cube.
    edge: usize,
    /// Horizon over the spacing.
    horizon: f64,
    level: usize,
    threads: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { does, edge, horizon, threads, .. } = self;
        let level = SimdLevel::all()[self.level];
        write!(f, "{does:?} {} points, m {horizon}, {level} {threads}", edge * edge * edge)
    }
}

fn cases() -> Vec<Case> {
    let base = Case { does: Does::Yields, edge: 64, horizon: 3.015, level: 0, threads: 1 };
    let mut cases = vec![base, Case { threads: 2, ..base }];
    cases.extend((1..SimdLevel::all().len()).map(|level| Case { level, ..base }));
    let others = [Does::Swings, Does::MayYield, Does::MayBreak];
    cases.extend(others.map(|does| Case { does, ..base }));
    cases.extend([8, 24].map(|edge| Case { edge, ..base }));
    // The paper's walls, as in `paper`, on two threads.
    cases.push(Case { edge: 67, horizon: 3.42, threads: 2, ..base });
    cases
}

/// Sizes of examples of the paper's Table 1, as cubes: points along an edge and the horizon with
/// which they have as many points and bonds.
fn paper() -> Vec<Case> {
    let of = |does, edge, horizon| Case { does, edge, horizon, level: 0, threads: 1 };
    vec![
        of(Does::MayBreak, 67, 3.42),
        of(Does::Yields, 67, 3.42),
        of(Does::Swings, 75, 3.55),
        of(Does::Swings, 28, 2.5),
        of(Does::Swings, 36, 3.45),
        of(Does::Swings, 54, 3.2),
    ]
}

fn main() {
    divan::main();
}

/// A cube of shaken points in rows.
fn cube(case: &Case) -> PeridynamicDomain {
    let yield_stress = if matches!(case.does, Does::MayYield) { 1e9 } else { 1e5 };
    let hardening = Hardening { yield_stress, hardening: 1e9, exponent: 1.0 };
    let mut law = PeridynamicLaw::elastic(7800.0, 200e9, 0.3);
    law.hardening = (!matches!(case.does, Does::Swings)).then_some(hardening);
    let breaking = BondBreaking { fracture_energy: 1e4, dust: 0.5 };
    law.breaking = matches!(case.does, Does::MayBreak).then_some(breaking);
    let n = case.edge;
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (state >> 11) as f64 / (1u64 << 53) as f64 * 0.2 - 0.1
    };
    let at = |k: usize| Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
    let places: Vec<Vec3> =
        (0..n * n * n).map(|k| (at(k) + Vec3::from([0; 3].map(|_| random()))) * 1e-3).collect();
    let volumes = vec![1e-9; places.len()];
    let mut body =
        PeridynamicDomain::new(places, volumes, case.horizon * 1e-3, law).expect("a cube");
    body.level = SimdLevel::all()[case.level];
    // Strained evenly and ever more, by far less than what breaks it.
    for (v, x) in body.velocities.iter_mut().zip(&body.places) {
        *v = Vec3::new(x.x, -0.5 * x.y, -0.5 * x.z) * 10.0;
    }
    body
}

#[divan::bench(args = cases(), sample_count = 10, sample_size = 1)]
fn steps(bencher: Bencher<'_, '_>, case: &Case) {
    run(bencher, case);
}

/// Four steps of a body that is led by the hand: whatever the forces, it strains on.
fn run(bencher: Bencher<'_, '_>, case: &Case) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(case.threads).build().expect("a pool");
    let mut body = cube(case);
    let led = body.velocities.clone();
    let dt = body.stable_step();
    bencher.counter(ItemsCount::new(body.bonds.count() * 4)).bench_local(|| {
        pool.install(|| (0..4).map(|_| body.advance(dt, |p, _| led[p]).yielding).sum::<usize>())
    });
}

/// Four steps at the paper's sizes.
#[divan::bench(args = paper(), sample_count = 5, sample_size = 1)]
fn paper_sizes(bencher: Bencher<'_, '_>, case: &Case) {
    run(bencher, case);
}
