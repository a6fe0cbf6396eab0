//! Node-steps a second of a shell's full step: items are control points times steps.
//!
//! `cargo bench -p cullet-shell --bench shell`.

use cullet_geometry::Vec3;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_model::Material;
use cullet_shell::domain::{ShellDomain, ShellMaterial};
use cullet_shell::midsurface::Midsurface;
use cullet_shell::section::SectionLaw;
use cullet_simd::{Real, SimdLevel};
use divan::Bencher;
use divan::counter::ItemsCount;

fn main() {
    divan::main();
}

/// A pane of glass of 100 × 100 cells that flexes.
fn pane<R: Real>() -> ShellDomain<R, 9> {
    let patch = NurbsPatch::sheet([0.4, 0.4], [100, 100], 2).expect("a sheet");
    let surface = Midsurface::of_patch(&patch);
    let points = surface.points();
    let glass = Material {
        density: 2500.0,
        young: 70e9,
        poisson: 0.22,
        failure_stress: 45e6,
        fracture_energy: 8.0,
    };
    let material = ShellMaterial {
        law: SectionLaw::new(&glass),
        density: glass.density,
        thickness: vec![8e-3; points],
        strength: vec![glass.failure_stress; points],
        softening_cells: 1.1,
    };
    let mut shell = ShellDomain::new(surface, material, SimdLevel::best());
    for (v, at) in shell.velocity.iter_mut().zip(&shell.surface.nodes) {
        *v = Vec3::new(0.0, 0.0, 1e-3 * (1.0 - 20.0 * at.norm_squared()));
    }
    shell
}

fn steps<R: Real>(bencher: Bencher<'_, '_>, threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let mut shell = pane::<R>();
    let nodes = shell.mass.len();
    bencher.counter(ItemsCount::new(nodes * 10)).bench_local(|| {
        pool.install(|| {
            for _ in 0..10 {
                shell.advance(|_, v| v);
            }
        });
    });
}

#[divan::bench(args = [1, 2])]
fn double(bencher: Bencher<'_, '_>, threads: usize) {
    steps::<f64>(bencher, threads);
}

#[divan::bench(args = [1, 2])]
fn single(bencher: Bencher<'_, '_>, threads: usize) {
    steps::<f32>(bencher, threads);
}
