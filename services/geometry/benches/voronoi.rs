//! How long a Voronoi cell takes, one thread.

use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_geometry::voronoi::Cells;

fn main() {
    divan::main();
}

/// All cells of n uniformly random sites.
#[divan::bench(args = [1000, 10_000], sample_count = 5)]
fn random_sites(bencher: divan::Bencher<'_, '_>, n: u64) {
    let at = |i, k| 0.001 + 0.998 * unit(1, k, i);
    let sites: Vec<Vec3> = (0..n).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
    let cells = Cells::new(sites, Vec3::zeros(), Vec3::repeat(1.0)).unwrap();
    bencher.bench(|| (0..n as u32).map(|i| cells.cell(i).unwrap().len()).sum::<usize>());
}

/// All cells of n³ lattice sites, jittered by 1e-2 of the spacing.
#[divan::bench(args = [22], sample_count = 5)]
fn lattice_sites(bencher: divan::Bencher<'_, '_>, n: u64) {
    let sites = (0..n * n * n).map(|i| {
        let node = [i % n, i / n % n, i / (n * n)];
        let at = |k: usize| (node[k] as f64 + 0.5 + 0.02 * unit(3, k as u64, i)) / n as f64;
        Vec3::new(at(0), at(1), at(2))
    });
    let cells = Cells::new(sites.collect(), Vec3::zeros(), Vec3::repeat(1.0)).unwrap();
    let count = (n * n * n) as u32;
    bencher.bench(|| (0..count).map(|i| cells.cell(i).unwrap().len()).sum::<usize>());
}
