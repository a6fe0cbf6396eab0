use crate::bending::curvature_form;
use crate::law::{counted, generalised, generalised_slope, stretched};
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::steps::SheetRun;
use crate::tests::{setup, with};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::MembraneLaw;
use cullet_simd::SimdLevel;
use std::sync::Arc;

/// A sheet with a notch that turns, is bent, crumpled and a little torn.
fn crumpled(law: MembraneLaw, poisson: f64) -> SheetRun {
    let setup = with(setup(), |sheet| {
        sheet.material.poisson = poisson;
        sheet.material.law = law;
        sheet.material.fracture_energy = 50.0;
        sheet.material.strength = 2e4;
        sheet.material.bending_floor = 1.0;
        sheet.notches = vec![vec![[0.1, -0.1], [0.1, 0.05]]];
    });
    let prepared = Arc::new(PreparedMembrane::new(&setup).unwrap());
    let mut state = SheetState::start(&prepared);
    for (i, x) in state.places.iter_mut().enumerate() {
        let chance = |k: u64| unit(3, k, i as u64) - 0.5;
        *x = *x * 1.02 + Vec3::new(chance(0), chance(1), chance(2)) * 5e-4;
        x.z += 5.0 * x.x * x.x - 2.0 * x.x * x.y;
        // Far from the origin: places are not f32.
        *x += Vec3::new(40.0, -70.0, 10.0);
        state.velocities[i] = Vec3::new(1.0, -2.0, 3.0).cross(x) * 1e-2;
    }
    SheetRun::new(prepared, state, vec![])
}

/// Forces as their formulas have them, in f64 and bond by bond \[N\], and the greatest sum of the
/// sizes of forces on a point.
fn by_formula(run: &SheetRun, before: &SheetState) -> (Vec<Vec3>, f64) {
    let (prepared, table) = (&run.prepared, &run.table);
    let material = &prepared.sheet().material;
    let bonds = &prepared.bonds;
    let half = 0.5 * prepared.step();
    let places: Vec<Vec3> =
        before.places.iter().zip(&before.velocities).map(|(x, v)| x + v * half).collect();
    let off = |i: usize, b: usize| places[bonds.ends[b] as usize] - places[i];
    let g = |i: usize, b: usize| generalised(material.law, off(i, b).norm() * table.rest[b]);
    let dilation = |i: usize| {
        let sum = bonds.of(i).map(|b| table.stiffness[b] * counted(g(i, b), run.state.memory(b)));
        let theta = 2.0 / table.sums[i] * sum.sum::<f64>();
        2.0 * prepared.dilatation * prepared.points.areas[i] * theta / table.sums[i]
    };
    let moments = |i: usize| {
        let scale = prepared.points.areas[i] * prepared.bending;
        let kappa = prepared.stencils.curvature(i, &places);
        curvature_form(&kappa, material.poisson).1.map(|m| m * scale)
    };
    let (dilations, moments): (Vec<f64>, Vec<[Vec3; 3]>) =
        (0..places.len()).map(|i| (dilation(i), moments(i))).unzip();
    let (mut forces, mut most) = (Vec::new(), 0.0_f64);
    for i in 0..places.len() {
        let (mut force, mut size) = (Vec3::zeros(), 0.0);
        for b in bonds.of(i).filter(|&b| before.damage[b] < 1.0) {
            let (mut memory, k, rest) = (before.memory(b), table.stiffness[b], table.rest[b]);
            let (g, j) = (g(i, b), bonds.ends[b] as usize);
            let mut tension =
                stretched(material.law, g, &mut memory, table.limits[b], true).tension;
            tension += (1.0 - memory.damage) * (dilations[i] + dilations[j]);
            let slope = generalised_slope(material.law, off(i, b).norm() * rest);
            let along = off(i, b).normalize();
            let closing = (before.velocities[j] - before.velocities[i]).dot(&along);
            let damping = material.damping * prepared.stable * (1.0 - memory.damage);
            let pull = along * (k * rest * (tension * slope + damping * rest * closing));
            force += pull;
            size += pull.norm();
        }
        for n in prepared.stencils.of(i) {
            let pair = |moments: &[Vec3; 3], n: usize| {
                let [xx, xy, yy] = prepared.stencils.terms[n].curvature;
                moments[0] * xx + moments[1] * xy + moments[2] * yy
            };
            let twin = prepared.stencils.twins[n] as usize;
            let other = &moments[prepared.stencils.ends[n] as usize];
            let bend = pair(&moments[i], n) - pair(other, twin);
            force += bend;
            size += bend.norm();
        }
        forces.push(force);
        most = most.max(size);
    }
    (forces, most)
}

/// Sixteen side by side in f32 are what the formulas say, to the rounding of strains in f32.
#[test]
fn forces_are_those_of_the_formulas() {
    for (law, poisson) in [
        (MembraneLaw::Brittle, 1.0 / 3.0),
        (MembraneLaw::Brittle, 0.2),
        (MembraneLaw::Foil, 1.0 / 3.0),
        (MembraneLaw::Foil, 0.45),
        (MembraneLaw::Rubber, 1.0 / 3.0),
    ] {
        let mut run = crumpled(law, poisson);
        let before = run.state.clone();
        run.advance();
        assert!(run.books.sums.broken + run.books.sums.plastic > 0.0, "{law:?}");
        let (forces, most) = by_formula(&run, &before);
        let dt = run.prepared.step();
        for (i, force) in forces.iter().enumerate() {
            let gained = run.state.velocities[i] - before.velocities[i];
            let found = gained * (run.masses[i][1] / dt);
            let off = (found - force).norm() / most;
            assert!(off < 3e-6, "{law:?} {poisson}: point {i} by {off:e}");
        }
    }
}

/// The width of registers changes no bit.
#[test]
fn all_levels_give_the_same_bits() {
    for (law, poisson) in [(MembraneLaw::Foil, 0.2), (MembraneLaw::Rubber, 1.0 / 3.0)] {
        let ends = SimdLevel::all().into_iter().map(|level| {
            let mut run = crumpled(law, poisson);
            run.kernel.use_level(level);
            (0..30).for_each(|_| {
                run.advance();
            });
            assert!(run.books.sums.breaks > 0 || run.books.sums.plastic > 0.0, "{law:?}");
            run.state
        });
        let ends: Vec<SheetState> = ends.collect();
        assert!(ends.len() > 1 && ends.windows(2).all(|two| two[0] == two[1]), "{law:?}");
    }
}
