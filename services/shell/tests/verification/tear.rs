//! S16: a trouser tear. The legs of a slit sheet are pulled apart, one up and one down, until the
//! sheet tears between them.

use cullet_geometry::Vec3;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_model::Material;
use cullet_shell::domain::{ShellDomain, ShellMaterial};
use cullet_shell::midsurface::Midsurface;
use cullet_shell::section::SectionLaw;
use cullet_simd::SimdLevel;

const THICKNESS: f64 = 0.25e-3;
const CELL: f64 = 1e-3;
const SIZE: [f64; 2] = [100e-3, 60e-3];
const SLIT: f64 = 30e-3;
const SPEED: f64 = 1.0;

/// How far the legs are pulled: as far as the slit is long until they are upright, and 15 mm more.
const PULL: f64 = 45e-3;

/// A sheet that hardly stretches at the force that tears it.
const SHEET: Material = Material {
    density: 1000.0,
    young: 100e6,
    poisson: 0.3,
    failure_stress: 8e6,
    fracture_energy: 1000.0,
};

/// Legs that do not stretch give F = G_f t/2. The family does not reach that: near the tip the
/// sheet is twisted, which opens cracks at 45° to the tear on its two faces, and cells break twice
/// over in a band. The figure is printed, and must not be below the toughness nor get worse.
#[test]
fn s16_a_trouser_tear_costs_more_than_its_energy() {
    let cells = SIZE.map(|s| (s / CELL).round() as usize);
    let patch = NurbsPatch::sheet(SIZE, cells, 2).unwrap();
    let surface = Midsurface::of_patch(&patch);
    let places: Vec<Vec3> = (0..surface.points()).map(|p| surface.surface_point(p).place).collect();
    let tip = SLIT - 0.5 * SIZE[0];
    let tears = |x: &Vec3| x.x > tip - 4.0 * CELL;
    let strength = |x: &Vec3| if tears(x) { SHEET.failure_stress } else { f64::INFINITY };
    let material = ShellMaterial {
        law: SectionLaw { most_strain: 2.0, ..SectionLaw::new(&SHEET) },
        density: SHEET.density,
        thickness: vec![THICKNESS; places.len()],
        strength: places.iter().map(strength).collect(),
        softening_cells: 1.1,
    };
    let mut shell = ShellDomain::<f64, 9>::new(surface, material, SimdLevel::best());
    for (point, at) in places.iter().enumerate() {
        if at.x < tip && at.y < 0.0 && at.y > -0.5 * CELL {
            shell.notch(point, [0.0, 1.0]);
        }
    }
    shell.wake_tips();
    let nodes = shell.surface.nodes.clone();
    // Which way a control point is pulled: the ends of the legs, up and down.
    let way = |node: usize| match nodes.get(node) {
        Some(at) if at.x < 1.1 * CELL - 0.5 * SIZE[0] && at.y.abs() > 2.0 * CELL => at.y.signum(),
        _ => 0.0,
    };
    let grips: Vec<usize> = (0..nodes.len()).filter(|&n| way(n) != 0.0).collect();
    let torn = |shell: &ShellDomain<f64, 9>| {
        let broken = (0..places.len()).filter(|&p| shell.state(p).is_broken());
        broken.map(|p| places[p].x).fold(tip, f64::max) - tip
    };
    let (mut work, mut taken) = (0.0, 0.0);
    for step in 0..(PULL / SPEED / shell.step) as usize {
        let speed = SPEED * (step as f64 / 500.0).min(1.0);
        let tally = shell.advance(|node, v| match way(node) {
            0.0 => v,
            way => Vec3::new(0.0, 0.0, way * speed),
        });
        taken += tally.points.dissipated + tally.met;
        let force: f64 = grips.iter().map(|&n| -shell.force(n).z * way(n)).sum();
        work += force * speed * shell.step;
    }
    let (length, sums) = (torn(&shell), shell.sums());
    let cost = taken / (SHEET.fracture_energy * THICKNESS * length);
    let balance = (sums.kinetic + sums.elastic + taken) / work;
    println!("S16: torn {:.1} mm, costs {cost:.2} G_f, energy {balance:.3}", length * 1e3);
    assert!(length > 5e-3, "torn {length} m");
    assert!((0.9..15.0).contains(&cost), "a tear costs {cost} G_f");
    assert!((balance - 1.0).abs() < 0.05, "energy times {balance}");
}
