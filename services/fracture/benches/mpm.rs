//! Particle-steps a second of the full step, damage on: items are particle-steps.

use cullet_fracture::Material;
use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::Domain;
use cullet_fracture::particles::Particles;
use cullet_geometry::{Vec3, math::unit};
use divan::Bencher;
use divan::counter::ItemsCount;

const STEPS: usize = 10;

fn main() {
    divan::main();
}

/// A turning, stretching cube of about `count` points, eight a cell; `broken` slabs a cell thick.
fn cube(count: usize, broken: bool) -> Domain {
    let side = (1..).find(|n| n * n * n >= count).unwrap_or(1);
    let spacing = 0.2 / (0.5 * side as f64);
    let stone = Material {
        density: 2300.0,
        young: 40e9,
        poisson: 0.2,
        failure_stress: 30e6,
        fracture_energy: 25.0,
    };
    let mut points = Vec::new();
    for i in 0..side * side * side {
        let cell = [i / (side * side), i / side % side, i % side];
        let at = |a: usize| {
            let jitter = 0.5 + 0.5 * (unit(1, a as u64, i as u64) - 0.5);
            (cell[a] as f64 + jitter) * 0.5 * spacing - 0.1
        };
        points.push(Vec3::new(at(0), at(1), at(2)));
    }
    let mut particles = Particles::at_rest(&points, 0.008, stone.density);
    for (p, x) in points.iter().enumerate() {
        particles.damage[p] = f64::from(u8::from(broken && (x.x / spacing).rem_euclid(6.0) < 1.0));
    }
    let law = Softening::on_grid(&stone, spacing);
    let mut domain = Domain::new(particles, &stone, law, Vec3::repeat(spacing));
    let spin = Vec3::new(3.0, -2.0, 4.0);
    domain.launch(|x| spin.cross(x) + Vec3::new(0.3 * x.x, -0.1 * x.y, 0.2 * x.z));
    domain.advance();
    domain
}

fn steps(bencher: Bencher<'_, '_>, threads: usize, count: usize, broken: bool) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let mut domain = cube(count, broken);
    let items = domain.particles.len() * STEPS;
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        pool.install(|| {
            for _ in 0..STEPS {
                divan::black_box(domain.advance());
            }
        });
    });
}

#[divan::bench(args = [17_576, 140_608], sample_count = 10, sample_size = 1)]
fn intact_one_thread(bencher: Bencher<'_, '_>, count: usize) {
    steps(bencher, 1, count, false);
}

#[divan::bench(args = [17_576, 140_608], sample_count = 10, sample_size = 1)]
fn cracked_one_thread(bencher: Bencher<'_, '_>, count: usize) {
    steps(bencher, 1, count, true);
}

#[divan::bench(args = [17_576, 140_608], sample_count = 10, sample_size = 1)]
fn cracked_two_threads(bencher: Bencher<'_, '_>, count: usize) {
    steps(bencher, 2, count, true);
}
