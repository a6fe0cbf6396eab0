//! Shells on subdivision surfaces of triangles against formulas: S7, S8, S9, E9, S18, S19.

use crate::equilibrium::elastic;
use crate::loop_meshes::{HeldShares, LoopShell, Triangles, hold, settled};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_shell::domain::ShellDomain;
use cullet_shell::midsurface::{LoopError, Midsurface};
use cullet_simd::{Real, SimdLevel};
use std::f64::consts::TAU;

fn surface(mesh: &Triangles) -> Midsurface {
    Midsurface::of_triangles(&mesh.vertices, &mesh.triangles).unwrap()
}

fn shell(mesh: &Triangles, material: [f64; 3]) -> LoopShell {
    elastic(surface(mesh), material, SimdLevel::best())
}

fn assert_near(what: &str, found: f64, wanted: f64, share: f64) {
    println!("{what}: {found:.6e}, {wanted:.6e} wanted, {:+.3} %", 100.0 * (found / wanted - 1.0));
    assert!((found / wanted - 1.0).abs() <= share, "{what}: {found}, not {wanted}");
}

fn sphere_of_valences() -> Vec<Triangles> {
    [4, 5, 6].map(|sectors| Triangles::dome(sectors, 8)).to_vec()
}

/// The functions add up to one, and reproduce a plane with its tangents, whatever the valences.
#[test]
fn loop_functions_reproduce_planes() {
    let flat = |v: Vec3| Vec3::new(v.x, v.y, 0.3 * v.x - 0.2 * v.y);
    let meshes = [
        Triangles::strip([1.0, 0.8], [8, 6]).irregular(3).mapped(flat),
        Triangles::dome(5, 6).mapped(|v| flat(v * (2.0 - v.z))),
    ];
    for mesh in meshes {
        let surface = surface(&mesh);
        let mut kinds = std::collections::BTreeSet::new();
        for point in 0..surface.points() {
            let (_, table) = surface.at(point);
            kinds.insert(table.value.iter().filter(|v| **v != 0.0).count());
            let sum: f64 = table.value.iter().sum();
            assert!((sum - 1.0).abs() < 1e-14, "{sum}");
            for row in &table.derivatives {
                assert!(row.iter().sum::<f64>().abs() < 1e-13);
            }
            let at = surface.surface_point(point);
            assert!((at.place.z - flat(at.place).z).abs() < 1e-12, "{}", at.place);
            assert!(at.curvatures.iter().all(|c| c.dot(&at.normal).abs() < 1e-10));
        }
        println!("functions of cells: {kinds:?}");
        assert!(kinds.len() > 1);
    }
}

/// Areas and curvatures of a sphere; vertices lie on the surface.
#[test]
fn loop_surfaces_are_round() {
    for mesh in sphere_of_valences() {
        let surface = surface(&mesh);
        let on = surface.at_vertices(&surface.nodes);
        let off = on.iter().zip(&mesh.vertices).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-10, "{off}");
        let points: Vec<_> = (0..surface.points()).map(|p| surface.surface_point(p)).collect();
        let area: f64 = points.iter().map(|p| p.area).sum();
        let far = points.iter().map(|p| (p.place.norm() - 1.0).abs()).fold(0.0, f64::max);
        println!("sphere: area off by {:.2e}, radius by {far:.2e}", area / TAU - 1.0);
        assert!((area / TAU - 1.0).abs() < 5e-3 && far < 5e-3);
    }
}

#[test]
fn what_is_no_surface_is_refused() {
    let flat = Triangles::strip([1.0, 1.0], [4, 4]);
    let mut turned = flat.clone();
    turned.triangles[3].swap(0, 1);
    let of = |m: &Triangles| Midsurface::of_triangles(&m.vertices, &m.triangles).map(|_| ());
    assert!(matches!(of(&turned), Err(LoopError::Edge { .. })));
    let mut loose = flat.clone();
    loose.vertices.push(Vec3::zeros());
    assert!(matches!(of(&loose), Err(LoopError::Fan { .. })));
    let many = Triangles::dome(12, 3);
    assert!(matches!(of(&many), Err(LoopError::Functions { found: 18, .. })));
    assert!(matches!(Midsurface::of_triangles(&[], &[]), Err(LoopError::Empty)));
}

/// S7: the whole Scordelis–Lo roof under its own weight.
#[test]
fn loop_s7_a_roof_sags() {
    for (cells, bar) in [([16, 20], 0.03), ([32, 36], 0.01)] {
        let wide = 80.0_f64.to_radians();
        let mesh = Triangles::strip([50.0, 25.0 * wide], cells).mapped(|v| {
            let angle = v.y / 25.0 - 0.5 * wide;
            Vec3::new(25.0 * angle.sin(), v.x - 25.0, 25.0 * angle.cos())
        });
        let mut shell = shell(&mesh, [4.32e8, 0.0, 0.25]);
        let ends = || (0..mesh.vertices.len()).filter(|&v| mesh.vertices[v].y.abs() > 24.999);
        let mut held = hold(&shell, ends(), 0);
        held.extend(hold(&shell, ends(), 2));
        held.extend(hold(&shell, [mesh.nearest(Vec3::new(0.0, 0.0, 25.0))].into_iter(), 1));
        let areas = areas(&shell);
        let loads: Vec<Vec3> = areas.iter().map(|a| Vec3::new(0.0, 0.0, -90.0 * a)).collect();
        let u = settled(&mut shell, &loads, &held, 1, 1e-5);
        let edge =
            mesh.nearest(Vec3::new(25.0 * (0.5 * wide).sin(), 0.0, 25.0 * (0.5 * wide).cos()));
        let sag = -shell.surface.at_vertices(&u)[edge].z;
        assert_near(&format!("Loop S7, {cells:?}"), sag, 0.3006, bar);
    }
}

/// Area that each control point has of the surface.
fn areas(shell: &LoopShell) -> Vec<f64> {
    let mut areas = vec![0.0; shell.mass.len()];
    for point in 0..shell.points() {
        let (nodes, shares) = shell.functions(point);
        let area = shell.surface.surface_point(point).area;
        nodes.iter().zip(shares).for_each(|(&n, s)| areas[n as usize] += area * s);
    }
    areas
}

/// S8: a cylinder between rigid diaphragms, pinched by two forces of 1; the whole of it.
#[test]
fn loop_s8_a_cylinder_is_pinched() {
    for (around, rows, bar) in [(64, 40, 0.2), (112, 64, 0.08)] {
        let mesh = Triangles::tube(around, rows, 600.0)
            .mapped(|v| Vec3::new(300.0 * v.x, 300.0 * v.y, v.z - 300.0));
        let mut shell = shell(&mesh, [3e6, 0.3, 3.0]);
        let rim: Vec<usize> = mesh.rim().into_iter().map(|v| v as usize).collect();
        let mut held = hold(&shell, rim.iter().copied(), 0);
        held.extend(hold(&shell, rim.iter().copied(), 1));
        let at = mesh.nearest(Vec3::new(300.0, 0.0, 0.0));
        held.extend(hold(&shell, [mesh.nearest(Vec3::new(0.0, 300.0, 0.0))].into_iter(), 2));
        let loads = pushes(
            &shell,
            &mesh,
            &[(300.0 * Vec3::x(), -Vec3::x()), (-300.0 * Vec3::x(), Vec3::x())],
        );
        let u = settled(&mut shell, &loads, &held, 2, 1e-3);
        let moved = -shell.surface.at_vertices(&u)[at].x;
        assert_near(&format!("Loop S8, {around} x {rows}"), moved, 1.8248e-5, bar);
    }
}

/// Forces at the vertices nearest to places, on control points.
fn pushes(shell: &LoopShell, mesh: &Triangles, forces: &[(Vec3, Vec3)]) -> Vec<Vec3> {
    let mut loads = vec![Vec3::zeros(); shell.mass.len()];
    for &(place, force) in forces {
        for (node, share) in shell.surface.vertex_shares(mesh.nearest(place)) {
            loads[node as usize] += force * share;
        }
    }
    loads
}

/// S9: a hemisphere pulled and pushed by forces of 2 at its free edge, along the first.
fn pulled(mesh: &Triangles) -> f64 {
    let mut shell = shell(mesh, [6.825e7, 0.3, 0.04]);
    let (x, y) = (10.0 * Vec3::x(), 10.0 * Vec3::y());
    let at = [x, y, -x, -y].map(|place| mesh.nearest(place));
    // The symmetry of the loads: nothing pushes on these.
    let mut held = hold(&shell, [at[0], at[2]].into_iter(), 1);
    held.extend(hold(&shell, [at[1], at[3]].into_iter(), 0));
    held.extend(hold(&shell, [at[0], at[2]].into_iter(), 2));
    let [one, other] = [1, 3].map(|k| shell.surface.vertex_shares(at[k]));
    let apart = other.into_iter().map(|(node, share)| (node, -share));
    held.push(HeldShares { shares: one.into_iter().chain(apart).collect(), axis: 2 });
    let forces = [(x, Vec3::x()), (-x, -Vec3::x()), (y, -Vec3::y()), (-y, Vec3::y())];
    let loads = pushes(&shell, mesh, &forces.map(|(at, f)| (at, 2.0 * f)));
    let u = settled(&mut shell, &loads, &held, 2, 1e-5);
    let moved = shell.surface.at_vertices(&u);
    0.5 * (moved[at[0]].x - moved[at[2]].x)
}

#[test]
fn loop_s9_a_hemisphere_with_a_hole_is_pulled_and_pushed() {
    let top = 72.0_f64.to_radians();
    for (around, rows, bar) in [(48, 16, 0.1), (80, 26, 0.03)] {
        let mesh = Triangles::tube(around, rows, top).mapped(|v| {
            let r = 10.0 * v.z.cos();
            Vec3::new(r * v.x, r * v.y, 10.0 * v.z.sin())
        });
        assert_near(&format!("Loop S9, {around} x {rows}"), pulled(&mesh), 0.0934, bar);
    }
}

/// The same without a hole, 0.0924: poles of four, five and six neighbours do no harm.
#[test]
fn loop_s9_poles_of_any_valence_do_no_harm() {
    for (sectors, rows) in [(4, 28), (5, 24), (6, 20)] {
        let mesh = Triangles::dome(sectors, rows).mapped(|v| 10.0 * v);
        assert_near(
            &format!("Loop S9, pole of {sectors}, {rows} rows"),
            pulled(&mesh),
            0.0924,
            0.05,
        );
    }
}

/// E9: a simply supported square plate under pressure.
#[test]
fn loop_e9_a_plate_sags_under_pressure() {
    for (cells, bar) in [([14, 16], 0.03), ([28, 32], 0.025)] {
        let flat = Triangles::strip([1.0, 1.0], cells);
        let kinds = [
            ("squares", Triangles::squares([1.0, 1.0], cells)),
            ("irregular squares", Triangles::squares([1.0, 1.0], cells).irregular(2)),
            ("regular", flat.clone()),
            ("irregular", flat.irregular(2)),
        ];
        for (what, mesh) in kinds {
            let mut shell = shell(&mesh, [1e9, 0.3, 0.01]);
            let rim: Vec<usize> = mesh.rim().into_iter().map(|v| v as usize).collect();
            let mut held = hold(&shell, rim.into_iter(), 2);
            let corners = [0.0, 1.0].map(|x| mesh.nearest(Vec3::new(x, 0.0, 0.0)));
            held.extend(hold(&shell, corners.into_iter(), 1));
            held.extend(hold(&shell, corners.into_iter().take(1), 0));
            let loads: Vec<Vec3> = areas(&shell).iter().map(|a| Vec3::new(0.0, 0.0, *a)).collect();
            let u = settled(&mut shell, &loads, &held, 0, 1e-7);
            let middle = mesh.nearest(Vec3::new(0.5, 0.5, 0.0));
            let away = mesh.vertices[middle] - Vec3::new(0.5, 0.5, 0.0);
            let stiffness = 1e9 * 1e-6 / 12.0 / (1.0 - 0.09);
            let wanted = 0.00406235 / stiffness * (1.0 - 4.9 * away.norm_squared());
            let sag = shell.surface.at_vertices(&u)[middle].z;
            assert_near(&format!("Loop E9, {what} {cells:?}"), sag, wanted, bar);
        }
    }
}

fn meshes() -> [Triangles; 3] {
    let bent = |v: Vec3| Vec3::new(0.1 * (v.x / 0.1).sin(), v.y, 0.1 * (v.x / 0.1).cos());
    [
        Triangles::strip([0.2, 0.1], [14, 8]).irregular(7).mapped(bent),
        Triangles::dome(5, 7).mapped(|v| 0.1 * v),
        Triangles::strip([0.2, 0.1], [14, 8]),
    ]
}

fn noisy<R: Real>(mesh: &Triangles, level: SimdLevel) -> ShellDomain<R, 16> {
    let mut shell: ShellDomain<R, 16> = elastic(surface(mesh), [70e9, 0.22, 2e-3], level);
    for (n, u) in shell.displacement.iter_mut().enumerate() {
        for (axis, u) in u.iter_mut().enumerate().take(3) {
            *u = 2e-4 * (unit(5, axis as u64, n as u64) - 0.5);
        }
    }
    shell
}

/// S18: f = −∂W/∂x, and neither force nor torque on the whole; none at all when it is only moved.
#[test]
fn loop_s18_forces_are_the_slope_of_the_energy() {
    for mesh in meshes() {
        let mut shell: LoopShell = noisy(&mesh, SimdLevel::best());
        shell.strain();
        let (mut net, mut torque, mut size) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for n in 0..shell.mass.len() {
            let force = shell.force(n);
            net += force;
            torque += (shell.surface.nodes[n] + shell.moved(n)).cross(&force);
            size += force.norm();
        }
        assert!(net.norm() < 1e-14 * size && torque.norm() < 1e-14 * size, "{net} {torque}");
        let last = shell.mass.len() - 3;
        for n in [0, 17, 40, last] {
            let force = shell.force(n);
            for axis in 0..3 {
                let here = shell.displacement[n][axis];
                let step = 1e-8;
                let mut at = |u: f64| {
                    shell.displacement[n][axis] = u;
                    shell.elastic_energy()
                };
                let slope = (at(here + step) - at(here - step)) / (2.0 * step);
                at(here);
                let off = (force[axis] + slope).abs() / force.norm();
                assert!(off < 1e-6, "{n}, {axis}: {} and {slope}", force[axis]);
            }
        }
        let turn = nalgebra::Rotation3::new(Vec3::new(0.4, -0.9, 0.3));
        for n in 0..shell.mass.len() {
            let x = shell.surface.nodes[n];
            let u = turn * x + Vec3::new(0.1, 0.2, -0.3) - x;
            (0..3).for_each(|c| shell.displacement[n][c] = u[c]);
        }
        shell.strain();
        let left: f64 = (0..shell.mass.len()).map(|n| shell.force(n).norm()).sum();
        assert!(left < 1e-8 * size, "{left} of {size}");
    }
}

/// The same bits on every path and for one or two threads, in both precisions.
#[test]
fn loop_bits_do_not_depend_on_registers_or_threads() {
    fn run<R: Real>(mesh: &Triangles, level: SimdLevel, threads: usize) -> Vec<Vec3> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut shell: ShellDomain<R, 16> = noisy(mesh, level);
            for _ in 0..50 {
                shell.advance(|_, v| v);
            }
            (0..shell.mass.len()).map(|n| shell.moved(n)).collect()
        })
    }
    let mesh = &meshes()[0];
    let double = run::<f64>(mesh, SimdLevel::portable(), 1);
    let single = run::<f32>(mesh, SimdLevel::portable(), 1);
    for level in SimdLevel::all() {
        for threads in [1, 2] {
            assert_eq!(run::<f64>(mesh, level, threads), double, "{level} {threads}");
            assert_eq!(run::<f32>(mesh, level, threads), single, "{level} {threads}");
        }
    }
}

/// S19: at 0.95 of the stable step energy is kept for ten thousand steps, and at 1.05 it is not: in
/// the plane on a tube, in bending on a strip whose rows end at a straight rim.
#[test]
fn loop_s19_the_step_is_stable_up_to_its_bound() {
    let h = 0.01 * 0.75_f64.sqrt();
    let strip = Triangles::strip([0.1, 12.0 * h], [10, 12]);
    let tube = Triangles::tube(60, 12, 12.0 * h).mapped(|v| {
        let r = 0.6 / TAU;
        Vec3::new(r * v.x, r * v.y, v.z)
    });
    for (mesh, cells) in [(&strip, 0.25), (&strip, 0.5), (&tube, 2.0), (&tube, 4.0)] {
        let thickness = 0.01 / cells;
        for (share, holds) in [(0.95, true), (1.05, false)] {
            let mut shell = shell(mesh, [1e6, 0.22, thickness]);
            shell.step = share * shell.stable_step();
            for (n, v) in shell.velocity.iter_mut().enumerate() {
                *v = Vec3::from([0, 1, 2].map(|k| 1e-6 * (unit(3, k, n as u64) - 0.5)));
            }
            let mean = |shell: &mut LoopShell| {
                let mut sum = 0.0;
                for _ in 0..200 {
                    shell.strain();
                    let before = shell.velocity.clone();
                    let elastic = shell.elastic_energy();
                    shell.advance(|_, v| v);
                    let pairs = before.iter().zip(&shell.velocity).zip(&shell.mass);
                    sum += elastic + pairs.map(|((a, b), m)| 0.5 * m * a.dot(b)).sum::<f64>();
                }
                sum / 200.0
            };
            let first = mean(&mut shell);
            for _ in 0..10_000 {
                shell.advance(|_, v| v);
            }
            let ratio = mean(&mut shell) / first;
            println!("Loop S19, l/t {cells}, {share} of the step: energy times {ratio}");
            assert_eq!((ratio - 1.0).abs() < 1e-3, holds, "l/t {cells}, {share}: {ratio}");
        }
    }
}
