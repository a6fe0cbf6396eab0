//! F53 to F59: what the paper's formulas get wrong, of docs/failures.md.

use super::{begun, figure, harmless, setup, solve_from, with};
use crate::steps::SheetRun;
use crate::surface::TornSurface;
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::{ContinuumSetup, MembraneLaw, SheetDiffusion};

const LAWS: [MembraneLaw; 3] = [MembraneLaw::Brittle, MembraneLaw::Foil, MembraneLaw::Rubber];

/// Impulses of one step from rest on all points \[N·s\].
fn impulses(run: &mut SheetRun) -> Vec<Vec3> {
    run.state.velocities.fill(Vec3::zeros());
    run.advance();
    run.masses.iter().zip(&run.state.velocities).map(|(m, v)| v * m[1]).collect()
}

fn sizes(all: &[Vec3]) -> f64 {
    all.iter().map(Vec3::norm).sum()
}

/// A stretched sheet that was turned out of its plane is pulled within the plane that it is in now.
#[test]
fn f53_forces_are_along_bonds_as_they_are() {
    let turn = cullet_geometry::Quat::from_axis_angle(&Vec3::x_axis(), 0.7);
    let normal = turn * Vec3::z();
    for law in LAWS {
        let mut run = begun(&with(setup(), |sheet| sheet.material.law = law), |state| {
            state.places.iter_mut().for_each(|x| *x = turn * (*x * 1.01));
        });
        let all = impulses(&mut run);
        let across: f64 = all.iter().map(|p| p.dot(&normal).abs()).sum();
        assert!(
            sizes(&all) > 0.0 && across < 1e-3 * sizes(&all),
            "{law:?}: {across} {}",
            sizes(&all)
        );
    }
}

/// Whatever each point has taken up, both ends of a bond feel the same.
#[test]
fn f54_what_ends_have_taken_up_counts_alike() {
    let setup = with(setup(), |sheet| {
        let rows = vec![(0.0, 1.0), (1.0, 0.3)];
        sheet.diffusion =
            Some(SheetDiffusion { expansion: [0.02, 0.01], stiffness: rows, ..harmless(vec![]) })
                .into();
    });
    let mut run = begun(&setup, |state| {
        for (i, theta) in state.theta.iter_mut().enumerate() {
            *theta = unit(3, 0, i as u64);
        }
    });
    let all = impulses(&mut run);
    let sum: Vec3 = all.iter().sum();
    assert!(sizes(&all) > 0.0 && sum.norm() < 1e-9 * sizes(&all), "{}", sum.norm() / sizes(&all));
}

/// A sheet of which every bond breaks.
fn breakable(law: MembraneLaw) -> ContinuumSetup {
    with(setup(), |sheet| {
        sheet.material.law = law;
        sheet.material.fracture_energy = 10.0;
        sheet.material.strength = 5e3;
        sheet.spacing = 0.01;
    })
}

/// Work of stretching a sheet evenly from one stretch to another, by the forces on its points
/// \[J\].
fn work(run: &mut SheetRun, from: f64, to: f64) -> f64 {
    let steps = 800;
    let rest: Vec<Vec3> =
        run.prepared.points.places.iter().map(|p| Vec3::new(p[0], p[1], 0.0)).collect();
    let (mut sum, mut last) = (0.0, 0.0);
    for k in 0..=steps {
        let stretch = from + (to - from) * f64::from(k) / f64::from(steps);
        run.state.places.iter_mut().zip(&rest).for_each(|(x, p)| *x = p * stretch);
        let dt = run.prepared.step();
        let all = impulses(run);
        let force = -all.iter().zip(&rest).map(|(p, x)| p.dot(x)).sum::<f64>() / dt;
        if k > 0 {
            sum += 0.5 * (last + force) * (to - from) / f64::from(steps);
        }
        last = force;
    }
    sum
}

/// What pulls a sheet apart pays ½k s_c² for each bond, once; what softened stays soft.
#[test]
fn f55_a_bond_softens_once_and_remembers() {
    for law in LAWS {
        let mut run = begun(&breakable(law), |_| {});
        let bonds = &run.prepared.bonds;
        let critical = run.prepared.critical;
        let cost = 0.25 * bonds.stiffness.iter().sum::<f64>() * critical * critical;
        let limits = run.prepared.limits();
        let last = 1.1 * critical * critical / limits.first;
        let half = 1.0 + 0.5 * last;
        let there = work(&mut run, 1.0, half);
        // A foil is set then, and would be pressed back.
        if law != MembraneLaw::Foil {
            let back = work(&mut run, half, 1.0);
            let again = work(&mut run, 1.0, half);
            assert!(there > 0.0 && -back < 0.8 * there, "{law:?}: {there} {back}");
            assert!((back + again).abs() < 0.02 * there, "{law:?}: {back} {again}");
        }
        let whole = there + work(&mut run, half, 1.0 + last);
        assert!((whole / cost - 1.0).abs() < 0.05, "{law:?}: {}", whole / cost);
        assert!(run.state.damage.iter().all(|&d| d >= 1.0), "{law:?}");
        // It has come apart into its points, and each bond was seen to break.
        assert!((0.9..1.03).contains(&run.watch.overshoot()), "{}", run.watch.overshoot());
    }
}

/// Nothing pulls on a sheet at rest.
#[test]
fn f56_nothing_is_stressed_at_rest() {
    for law in LAWS {
        for poisson in [1.0 / 3.0, 0.3] {
            let setup = with(breakable(law), |sheet| sheet.material.poisson = poisson);
            let mut run = begun(&setup, |_| {});
            let rest = sizes(&impulses(&mut run));
            let mut run = begun(&setup, |state| {
                state.places.iter_mut().for_each(|x| *x *= 1.001);
            });
            let pulled = sizes(&impulses(&mut run));
            assert!(rest < 5e-3 * pulled, "{law:?} {poisson}: {rest} {pulled}");
        }
    }
}

/// From random values nothing grows beyond them, and all of it is kept.
#[test]
fn f57_what_spreads_stays_between_its_bounds() {
    let setup = with(setup(), |sheet| {
        sheet.diffusion =
            Some(SheetDiffusion { conductivity: [3e-2; 2], ..harmless(vec![]) }).into();
        sheet.notches = vec![vec![[0.1, -0.1], [0.1, 0.06]]];
    });
    let random = |i: usize| unit(8, 1, i as u64);
    let mut run = begun(&setup, |state| {
        let theta = state.theta.iter_mut().enumerate();
        theta.for_each(|(i, theta)| *theta = random(i));
    });
    let bonds = run.prepared.diffusion[0].clone();
    let (before, count) = (bonds.total(&run.state.theta), run.state.theta.len());
    let [low, high] = [f64::min, f64::max].map(|pick| (0..count).map(random).fold(0.5, pick));
    for _ in 0..20 * run.prepared.substeps {
        run.advance();
        let within = |t: &f64| (low..=high).contains(t);
        assert!(run.state.theta.iter().all(within));
    }
    assert!((bonds.total(&run.state.theta) / before - 1.0).abs() < 1e-12);
    let mean = before / bonds.capacities.iter().sum::<f64>();
    let spread = run.state.theta.iter().map(|t| (t - mean).abs()).fold(0.0, f64::max);
    assert!(spread < 0.9 * (high - mean), "it spreads: {spread}");
}

/// A cylinder costs ½BA/R², and wrinkles of a spacing far more: B is reported over the material's.
#[test]
fn f58_wrinkles_of_a_spacing_cost_something() {
    let setup = with(setup(), |sheet| sheet.material.bending_floor = 0.3);
    let bend = 0.1;
    let mut run = begun(&setup, |state| {
        for x in &mut state.places {
            *x = Vec3::new(bend * (x.x / bend).sin(), x.y, bend * (1.0 - (x.x / bend).cos()));
        }
    });
    let law = 0.5 * run.prepared.bending * 0.02 / (bend * bend);
    let cylinder = run.energies()[1];
    assert!((cylinder / law - 1.0).abs() < 0.03, "{}", cylinder / law);
    let mut run = begun(&setup, |state| {
        for (i, x) in state.places.iter_mut().enumerate() {
            x.z = 3e-3 * (unit(2, 0, i as u64) - 0.5);
        }
    });
    let wrinkled = run.energies()[1];
    assert!(wrinkled > 20.0 * cylinder, "{wrinkled} {cylinder}");
    let outcome = solve_from(&setup, 1, |_| {});
    // Thickness is 1 mm and 0.3 spacings are 1.5 mm.
    assert!((figure(&outcome, "bending_ratio") / 2.25 - 1.0).abs() < 1e-9);
}

/// However a sheet is torn, what is drawn of it has the area that it has.
#[test]
fn f59_no_area_comes_or_goes_where_it_is_torn() {
    let run = begun(&with(setup(), |sheet| sheet.spacing = 0.01), |_| {});
    let pairs = run.prepared.triangles.pairs().len();
    for share in [0.0, 0.2, 0.6] {
        let alive: Vec<bool> = (0..pairs).map(|n| unit(4, 0, n as u64) >= share).collect();
        let torn = TornSurface::new(&run.prepared.triangles, &alive, 0.0);
        let places = &torn.surface.reference;
        let twice = |t: &[u32; 3]| {
            let [[a, b], [c, d], [e, f]] = t.map(|v| places[v as usize].map(f64::from));
            (c - a) * (f - b) - (d - b) * (e - a)
        };
        let area: f64 = 0.5 * torn.surface.triangles.iter().map(twice).sum::<f64>();
        assert!((area / 0.02 - 1.0).abs() < 1e-6, "{share}: {area}");
    }
}
