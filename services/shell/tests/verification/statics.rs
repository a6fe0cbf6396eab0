//! Static benchmarks of shells: S1, S2, S7, S8, S9, E9.

use crate::equilibrium::{Freedoms, Grid, elastic, solve};
use cullet_geometry::Vec3;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_shell::domain::ShellDomain;
use cullet_shell::midsurface::Midsurface;
use cullet_simd::SimdLevel;
use std::f64::consts::{FRAC_PI_2, PI};

type Shell = ShellDomain<f64, 9>;

fn shell(patch: &NurbsPatch, material: [f64; 3]) -> Shell {
    elastic(Midsurface::of_patch(patch), material, SimdLevel::best())
}

fn assert_within(what: &str, found: f64, wanted: f64, share: f64) {
    println!("{what}: {found:.6e}, {wanted:.6e} wanted, {:+.3} %", 100.0 * (found / wanted - 1.0));
    assert!((found / wanted - 1.0).abs() <= share, "{what}: {found}, not {wanted}");
}

/// S1: a cantilever of 10 × 1 × 0.1 bent far by a dead load of 4 at its end.
#[test]
fn s1_a_cantilever_bends_far() {
    for (cells, bar) in [(16, 0.02), (32, 0.005)] {
        let patch = NurbsPatch::sheet([10.0, 1.0], [cells, 1], 2).unwrap();
        let grid = Grid::of(&patch);
        let mut shell = shell(&patch, [1.2e6, 0.0, 0.1]);
        let mut u = Vec::new();
        let tip = grid.column(grid.columns - 1);
        for load in 1..=10 {
            let mut freedoms = Freedoms::new(patch.points().len());
            for node in grid.column(0).into_iter().chain(grid.column(1)) {
                (0..3).for_each(|axis| freedoms.fix(node, axis));
            }
            let dead = |shell: &Shell| {
                let mut forces = vec![Vec3::zeros(); shell.mass.len()];
                // A line load over one cell of degree 2: a third on each control point.
                tip.iter().for_each(|&n| forces[n].z = 0.4 * f64::from(load) / 3.0);
                forces
            };
            solve(&mut shell, &mut freedoms, &dead, &mut u, [1e-5, 40.0]);
        }
        let moved = shell.moved(tip[1]);
        assert_within("S1 down", moved.z, 6.698, bar);
        assert_within("S1 back", -moved.x, 3.286, bar);
    }
}

/// S2: a strip of length 12 and EI = 100 is rolled up to a circle by a couple at its end.
#[test]
fn s2_a_strip_is_rolled_up() {
    let cells = 64;
    let patch = NurbsPatch::sheet([12.0, 1.0], [cells, 1], 2).unwrap();
    let grid = Grid::of(&patch);
    let mut shell = shell(&patch, [1.2e6, 0.0, 0.1]);
    let mut u = Vec::new();
    let [tip, before] = [1, 2].map(|k| grid.column(grid.columns - k));
    for load in 1..=40 {
        let mut freedoms = Freedoms::new(patch.points().len());
        for node in grid.column(0).into_iter().chain(grid.column(1)) {
            (0..3).for_each(|axis| freedoms.fix(node, axis));
        }
        let couple = 2.0 * PI * 100.0 / 12.0 * f64::from(load) / 40.0;
        // M δφ: the last two rows of control points lie along the end's tangent.
        let turning = |shell: &Shell| {
            let mut forces = vec![Vec3::zeros(); shell.mass.len()];
            for (&a, &b) in tip.iter().zip(&before) {
                let place = |n: usize| patch.points()[n] + shell.moved(n);
                let along = place(a) - place(b);
                let across = Vec3::new(-along.z, 0.0, along.x);
                let force = across * (couple / 3.0 / along.norm_squared());
                forces[a] += force;
                forces[b] -= force;
            }
            forces
        };
        solve(&mut shell, &mut freedoms, &turning, &mut u, [1e-5, 40.0]);
        if load == 20 {
            let moved = shell.moved(tip[1]);
            assert_within("S2 half, back", -moved.x, 12.0, 2e-3);
            assert_within("S2 half, up", moved.z, 24.0 / PI, 2e-3);
        }
    }
    let moved = shell.moved(tip[1]);
    assert_within("S2 back", -moved.x, 12.0, 2e-3);
    assert!(moved.z.abs() < 2e-3 * 12.0, "S2: not closed, {}", moved.z);
}

/// S7: the Scordelis–Lo roof under its own weight; a quarter of it.
#[test]
fn s7_a_roof_sags() {
    let half = 40.0_f64.to_radians();
    let cells = 16;
    let line = [[25.0, 0.0, 1.0], [25.0, 12.5, 1.0], [25.0, 25.0, 1.0]];
    // Around z from the crown on x to the free edge; z = 0 is the middle, z = 25 the diaphragm.
    let patch = NurbsPatch::revolved(line, half).unwrap().divided([cells, cells]);
    let grid = Grid::of(&patch);
    let mut shell = shell(&patch, [4.32e8, 0.0, 0.25]);
    let mut freedoms = Freedoms::new(patch.points().len());
    freedoms.mirror(&grid.column(0), &grid.column(1), 1);
    freedoms.mirror(&grid.row(0), &grid.row(1), 2);
    for node in grid.row(grid.rows - 1) {
        (0..2).for_each(|axis| freedoms.fix(node, axis));
    }
    // So little of its weight that the answer is linear.
    let little = |shell: &Shell| {
        shell.mass.iter().map(|m| Vec3::new(-90.0e-4 * m / 0.25, 0.0, 0.0)).collect()
    };
    solve(&mut shell, &mut freedoms, &little, &mut Vec::new(), [1e-5, 1.0]);
    let sag = -shell.moved(grid.at(grid.columns - 1, 0)).x * 1e4;
    assert_within("S7", sag, 0.3006, 3e-3);
}

/// S8: a cylinder between rigid diaphragms, pinched by two forces of 1; an eighth of it.
#[test]
fn s8_a_cylinder_is_pinched() {
    let line = [[300.0, 0.0, 1.0], [300.0, 150.0, 1.0], [300.0, 300.0, 1.0]];
    let patch = NurbsPatch::revolved(line, FRAC_PI_2).unwrap().divided([32, 32]);
    let grid = Grid::of(&patch);
    let mut shell = shell(&patch, [3e6, 0.3, 3.0]);
    let mut freedoms = Freedoms::new(patch.points().len());
    freedoms.mirror(&grid.column(0), &grid.column(1), 1);
    freedoms.mirror(&grid.column(grid.columns - 1), &grid.column(grid.columns - 2), 0);
    freedoms.mirror(&grid.row(0), &grid.row(1), 2);
    for node in grid.row(grid.rows - 1) {
        (0..2).for_each(|axis| freedoms.fix(node, axis));
    }
    let pinch = |shell: &Shell| {
        let mut forces = vec![Vec3::zeros(); shell.mass.len()];
        forces[grid.at(0, 0)].x = -0.25;
        forces
    };
    solve(&mut shell, &mut freedoms, &pinch, &mut Vec::new(), [1e-3, 1.0]);
    assert_within("S8", -shell.moved(grid.at(0, 0)).x, 1.8248e-5, 0.04);
}

/// S9: a hemisphere with a hole of 18°, pulled and pushed by forces of 2; a quarter of it.
#[test]
fn s9_a_hemisphere_is_pulled_and_pushed() {
    let (top, half) = (72.0_f64.to_radians(), 36.0_f64.to_radians());
    let middle = [10.0, 10.0 * half.tan(), half.cos()];
    let profile = [[10.0, 0.0, 1.0], middle, [10.0 * top.cos(), 10.0 * top.sin(), 1.0]];
    let patch = NurbsPatch::revolved(profile, FRAC_PI_2).unwrap().divided([16, 16]);
    let grid = Grid::of(&patch);
    let found = [2, 3].map(|rule| {
        let surface = Midsurface::with_rule(&patch, rule);
        let mut shell: Shell = elastic(surface, [6.825e7, 0.3, 0.04], SimdLevel::best());
        let mut freedoms = Freedoms::new(patch.points().len());
        freedoms.mirror(&grid.column(0), &grid.column(1), 1);
        freedoms.mirror(&grid.column(grid.columns - 1), &grid.column(grid.columns - 2), 0);
        freedoms.fix(grid.at(0, 0), 2);
        let pulls = |shell: &Shell| {
            let mut forces = vec![Vec3::zeros(); shell.mass.len()];
            forces[grid.at(0, 0)].x = 1e-4;
            forces[grid.at(grid.columns - 1, 0)].y = -1e-4;
            forces
        };
        solve(&mut shell, &mut freedoms, &pulls, &mut Vec::new(), [1e-5, 1.0]);
        shell.moved(grid.at(0, 0)).x * 1e4
    });
    assert_within("S9", found[0], 0.0934, 0.015);
    // Three Gauss points a direction lock (F86): 0.0785 with B-splines fitted to the sphere.
    assert_within("S9, full rule", found[1], 0.0785, 0.03);
}

/// E9: a simply supported square plate under pressure, w = 0.00406235 qa⁴/D at ν = 0.3.
#[test]
fn e9_a_plate_sags_under_pressure() {
    let cells = 16;
    let patch = NurbsPatch::sheet([1.0, 1.0], [cells, cells], 2).unwrap();
    let grid = Grid::of(&patch);
    let mut shell = shell(&patch, [1e9, 0.3, 0.01]);
    let mut freedoms = Freedoms::new(patch.points().len());
    let last = grid.columns - 1;
    for node in [grid.column(0), grid.column(last), grid.row(0), grid.row(last)].concat() {
        freedoms.fix(node, 2);
    }
    for node in 0..patch.points().len() {
        (0..2).for_each(|axis| freedoms.fix(node, axis));
    }
    let pressure =
        |shell: &Shell| shell.mass.iter().map(|m| Vec3::new(0.0, 0.0, 1e-3 * m / 0.01)).collect();
    solve(&mut shell, &mut freedoms, &pressure, &mut Vec::new(), [1e-7, 1.0]);
    let stiffness = 1e9 * 1e-6 / 12.0 / (1.0 - 0.09);
    let moved: Vec<Vec3> = (0..shell.mass.len()).map(|n| shell.moved(n)).collect();
    // The point nearest the middle is half a Gauss distance off it: the sag is flat there.
    let nearest = |p: &usize| (shell.surface.surface_point(*p).place.norm() * 1e9) as u64;
    let point = (0..shell.points()).min_by_key(nearest).unwrap();
    let sag = shell.interpolate(point, &moved).z;
    let away = shell.surface.surface_point(point).place;
    let wanted = 0.00406235 * 1e-3 / stiffness * (1.0 - 4.9 * away.norm_squared());
    assert_within("E9", sag, wanted, 5e-3);
}
