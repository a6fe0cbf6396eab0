//! Stress, strain and balance of sheets at rest.

use super::{grip, setup, with};
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::steps::SheetRun;
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::{
    ContinuumSetup, MembraneLaw, SheetDiffusion, SheetPlace, SheetRegion, SheetSource,
    SheetSourceKind,
};
use std::sync::Arc;

fn run(setup: &ContinuumSetup) -> SheetRun {
    let prepared = Arc::new(PreparedMembrane::new(setup).unwrap());
    let state = SheetState::start(&prepared);
    SheetRun::new(prepared, state, vec![])
}

/// Takes steps, each of which takes a share of all velocities.
fn settle(run: &mut SheetRun, steps: u32, share: f64) {
    for _ in 0..steps {
        run.advance();
        run.state.velocities.iter_mut().for_each(|v| *v *= 1.0 - share);
    }
}

/// Mean of ∂x/∂X and ∂y/∂Y over points in the middle.
fn stretches(run: &SheetRun, middle: impl Fn(SheetPlace) -> bool) -> [f64; 2] {
    let mut sum = [0.0; 3];
    for (i, &place) in run.prepared.points.places.iter().enumerate() {
        if middle(place) {
            let [x, y] = run.stencils.slopes(i, &run.state.places);
            sum = [sum[0] + x.x, sum[1] + y.y, sum[2] + 1.0];
        }
    }
    [sum[0] / sum[2], sum[1] / sum[2]]
}

/// A strip of 0.3 × 0.08 m, pulled to a stretch; what its right grip feels by width and thickness,
/// and the stretches in its middle.
fn pulled(law: MembraneLaw, poisson: f64, stretch: f64, steps: u32) -> [f64; 3] {
    let far = Vec3::new(0.28 * (stretch - 1.0), 0.0, 0.0);
    let setup = with(setup(), |sheet| {
        sheet.outline = vec![[0.0, 0.0], [0.3, 0.0], [0.3, 0.08], [0.0, 0.08]];
        sheet.spacing = 6.5e-3;
        sheet.material.law = law;
        sheet.material.poisson = poisson;
        sheet.material.fracture_energy = 1e9;
        sheet.material.strength = 1e12;
        sheet.grips = vec![
            grip([0.0, 0.0], [0.01, 0.08], vec![]),
            grip([0.29, 0.0], [0.3, 0.08], vec![(0.0, Vec3::zeros()), (0.05, far)]),
        ];
    });
    let mut run = run(&setup);
    let ramp = 12 * run.prepared.substeps;
    settle(&mut run, ramp + steps, 0.01);
    let before = run.books.grips[1];
    run.advance();
    let force = (run.books.grips[1] - before).x / run.prepared.step();
    let middle = |[x, y]: SheetPlace| (0.12..0.18).contains(&x) && (0.02..0.06).contains(&y);
    let [along, across] = stretches(&run, middle);
    [force / (0.08 * 1e-3), along, across]
}

/// T2: E and ν of a strip pulled by 0.1 %.
#[test]
fn a_pulled_strip_has_its_moduli() {
    for poisson in [0.2, 1.0 / 3.0, 0.45] {
        let [stress, along, across] = pulled(MembraneLaw::Brittle, poisson, 1.001, 3000);
        let young = stress / (along - 1.0);
        let found = -(across - 1.0) / (along - 1.0);
        assert!((young / 1e6 - 1.0).abs() < 0.02, "{poisson}: {young}");
        assert!((found - poisson).abs() < 0.01, "{poisson}: {found}");
    }
}

/// T3: rubber at twice its length.
#[test]
fn pulled_rubber_follows_its_closed_form() {
    let [stress, along, across] = pulled(MembraneLaw::Rubber, 1.0 / 3.0, 2.0, 3000);
    let law = 0.375e6 * (along - along.powf(-5.0 / 3.0));
    assert!(along > 1.9, "{along}");
    assert!((stress / law - 1.0).abs() < 0.03, "{stress} {law}");
    assert!((across / along.powf(-1.0 / 3.0) - 1.0).abs() < 0.03, "{across}");
}

/// ½A⁻¹ Σ T ξ n_x² of points in the middle: stress times thickness against lengths at rest \[N/m\].
fn virial(run: &SheetRun, middle: impl Fn(SheetPlace) -> bool) -> f64 {
    let (prepared, state) = (&run.prepared, &run.state);
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, _) in prepared.points.places.iter().enumerate().filter(|(_, p)| middle(**p)) {
        let of = |b: usize| {
            let j = prepared.bonds.ends[b] as usize;
            let off = state.places[j] - state.places[i];
            let along = prepared.bonds.lengths[b] * prepared.bonds.directions[b][0];
            run.tension(b, off.norm()) * off.x / off.norm() * along
        };
        sum += 0.5 * prepared.bonds.of(i).map(of).sum::<f64>() / prepared.points.areas[i];
        count += 1.0;
    }
    sum / count
}

fn inside([x, y]: SheetPlace) -> bool {
    (0.03..0.17).contains(&x) && (0.03..0.07).contains(&y)
}

/// T3: rubber stretched the same in both directions; nothing at rest.
#[test]
fn rubber_is_stretched_both_ways_by_its_closed_form() {
    let setup = with(setup(), |sheet| {
        sheet.material.law = MembraneLaw::Rubber;
        sheet.material.fracture_energy = 1e9;
    });
    let mut run = run(&setup);
    assert!(virial(&run, inside).abs() < 1e-12);
    for stretch in [1.25, 1.5, 2.0] {
        for (x, p) in run.state.places.iter_mut().zip(&run.prepared.points.places) {
            *x = Vec3::new(p[0], p[1], 0.0) * stretch;
        }
        let law = 0.375e3 * (stretch - f64::powi(stretch, -3));
        let found = virial(&run, inside);
        assert!((found / law - 1.0).abs() < 0.01, "{stretch}: {found} {law}");
    }
}

fn heated(by: f64, clamped: bool) -> SheetRun {
    let setup = with(setup(), |sheet| {
        let everywhere = SheetRegion::Box { low: [-1.0; 2], high: [1.0; 2] };
        sheet.diffusion = Some(SheetDiffusion {
            capacity: 1.0,
            conductivity: [1e-6; 2],
            expansion: [1e-3, 1e-3],
            start: 0.0,
            saturation: f64::INFINITY,
            stiffness: vec![],
            toughness: vec![],
            strength: vec![],
            exposure: 0.0,
            weight: 0.0,
            loss: 0.0,
            ambient: 0.0,
            sources: vec![SheetSource {
                region: everywhere,
                from: 0.0,
                until: f64::INFINITY,
                kind: SheetSourceKind::Held(by),
            }],
        })
        .into();
        if clamped {
            sheet.grips = [
                ([0.0, 0.0], [0.01, 0.1]),
                ([0.19, 0.0], [0.2, 0.1]),
                ([0.0, 0.0], [0.2, 0.01]),
                ([0.0, 0.09], [0.2, 0.1]),
            ]
            .map(|(low, high)| grip(low, high, vec![]))
            .to_vec();
        }
    });
    let mut run = run(&setup);
    settle(&mut run, 2500, 0.02);
    run
}

/// T6: a free sheet swells by βΔθ without stress; a clamped one bears −Eβ∆θ/(1−ν).
#[test]
fn heat_stretches_a_free_sheet_and_presses_a_clamped_one() {
    let run = heated(5.0, false);
    for stretch in stretches(&run, |_| true) {
        assert!(((stretch - 1.0) / 5e-3 - 1.0).abs() < 1e-3, "{stretch}");
    }
    let run = heated(0.5, true);
    let stress = virial(&run, inside) / 1e-3;
    let law = -1e6 * 5e-4 / (1.0 - 1.0 / 3.0);
    assert!((stress / law - 1.0).abs() < 0.02, "{stress} {law}");
}

/// T7: no force or torque on the whole, whatever it is bent, heated and damaged to, as it turns.
#[test]
fn inner_forces_have_no_sum_and_no_torque() {
    for (poisson, law) in [
        (1.0 / 3.0, MembraneLaw::Brittle),
        (0.2, MembraneLaw::Brittle),
        (0.45, MembraneLaw::Foil),
        (1.0 / 3.0, MembraneLaw::Rubber),
    ] {
        let setup = with(setup(), |sheet| {
            sheet.material.poisson = poisson;
            sheet.material.law = law;
            sheet.material.fracture_energy = 50.0;
            sheet.material.strength = 2e4;
            sheet.material.bending_floor = 1.0;
            sheet.notches = vec![vec![[0.1, -0.1], [0.1, 0.05]]];
        });
        let mut run = run(&setup);
        for (i, x) in run.state.places.iter_mut().enumerate() {
            let chance = |k: u64| unit(3, k, i as u64) - 0.5;
            *x = *x * 1.02 + Vec3::new(chance(0), chance(1), chance(2)) * 1e-3;
            x.z += 20.0 * x.x * x.x - 5.0 * x.x * x.y;
            run.state.velocities[i] = Vec3::new(1.0, -2.0, 3.0).cross(x);
        }
        let (before, places) = (run.state.velocities.clone(), run.state.places.clone());
        run.advance();
        let half = 0.5 * run.prepared.step();
        let (mut force, mut torque, mut size) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for (i, v) in before.iter().enumerate() {
            let change = (run.state.velocities[i] - v) * run.masses[i][1];
            force += change;
            torque += (places[i] + v * half).cross(&change);
            size += change.norm();
        }
        assert!(run.books.sums.broken + run.books.sums.plastic > 0.0, "{law:?}");
        assert!(force.norm() < 1e-14 * size, "{law:?}: {}", force.norm() / size);
        // The direction of a force is that of its bond to the rounding of f32, 6e-8.
        assert!(torque.norm() < 5e-11 * size, "{law:?}: {}", torque.norm() / size);
    }
}
