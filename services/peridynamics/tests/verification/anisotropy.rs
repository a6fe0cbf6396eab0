//! C7: bodies that are stiffer or stronger in some directions.

use crate::block;
use crate::cracks::{glass, opened};
use cullet_geometry::{Mat3, Quat, Vec3};
use cullet_peridynamics::anisotropy::{BondAnisotropy, BondElasticity, isotropic};
use cullet_peridynamics::{PeridynamicDomain, PeridynamicLaw};

/// Stress in the middle of a body that is strained evenly.
fn stress(law: PeridynamicLaw, turn: Quat, strain: &Mat3) -> Mat3 {
    let start = block([9, 9, 9], 0.01, 0.1, 3.015, PeridynamicLaw::elastic(1000.0, 1e9, 0.25));
    let places: Vec<Vec3> = start.places.iter().map(|x| turn * x).collect();
    let mut body = PeridynamicDomain::new(places, start.volumes.clone(), 0.03015, law).expect("");
    let norm = |p: usize| body.places[p].norm();
    let middle = (0..body.places.len()).min_by(|&a, &b| norm(a).total_cmp(&norm(b)));
    body.places.iter_mut().for_each(|x| *x += strain * *x);
    body.strain();
    body.stress(middle.expect("a point"))
}

fn law(bulk: f64, shear: f64, anisotropy: BondAnisotropy) -> PeridynamicLaw {
    let elastic = PeridynamicLaw::elastic(1000.0, 1e9, 0.25);
    PeridynamicLaw { bulk, shear, anisotropy: Some(anisotropy), ..elastic }
}

/// A cubic body has the stress of its three constants, within 0.1 %.
#[test]
fn c7_a_cubic_body_has_its_constants() {
    let (c11, c12, c44) = (1.5e9, 0.9e9, 0.45e9);
    let delta = |a: usize, b: usize| f64::from(u8::from(a == b));
    let tensor = |[a, b, c, d]: [usize; 4]| {
        let same = f64::from(u8::from(a == b && b == c && c == d));
        c12 * delta(a, b) * delta(c, d)
            + c44 * (delta(a, c) * delta(b, d) + delta(a, d) * delta(b, c))
            + (c11 - c12 - 2.0 * c44) * same
    };
    let found = BondElasticity::of_tensor(tensor);
    let anisotropy = BondAnisotropy { quartic: found.quartic, axis: Vec3::x(), strength: 1.0 };
    let law = law(found.bulk, found.shear, anisotropy);
    let strain = Mat3::new(2e-6, 1e-6, 0.0, 1e-6, -1e-6, 0.5e-6, 0.0, 0.5e-6, 3e-6);
    let found = stress(law, Quat::identity(), &strain);
    let mut wanted = Mat3::zeros();
    for k in 0..81 {
        let [a, b, c, d] = [k / 27, k / 9 % 3, k / 3 % 3, k % 3];
        wanted[(a, b)] += tensor([a, b, c, d]) * strain[(c, d)];
    }
    let miss = (found - wanted).amax() / wanted.amax();
    println!("C7, cubic: stress off by {miss:.1e}");
    assert!(miss < 1e-3, "{found}, {wanted}");
    // The three constants are not those of an isotropic body.
    assert!(((c11 - c12) / (2.0 * c44) - 1.0).abs() > 0.2);
}

/// The paper's G: it makes one direction softer, leaves K as it is, and turning it with the
/// body turns the stress.
#[test]
fn c7_the_matrix_of_the_paper_leaves_the_bulk_modulus() {
    let (bulk, shear) = (0.7e9, 0.4e9);
    let g = Mat3::from_diagonal(&Vec3::new(1.4, 1.0, 0.9));
    let of = |g: &Mat3| law(bulk, shear, BondAnisotropy::of_matrix(g));
    let along = |axis: usize| {
        let mut strain = Mat3::zeros();
        strain[(axis, axis)] = 1e-6;
        stress(of(&g), Quat::identity(), &strain)[(axis, axis)] / 1e-6
    };
    let [x, y, z] = [0, 1, 2].map(along);
    println!("C7, G: moduli {:.3}, {:.3}, {:.3} GPa", x / 1e9, y / 1e9, z / 1e9);
    assert!(x < 0.95 * y && y < z, "{x}, {y}, {z}");
    let pressure = stress(of(&g), Quat::identity(), &(Mat3::identity() * 1e-6)).trace() / 3.0;
    println!("C7, G: bulk modulus {:.5} of K", pressure / 3e-6 / bulk);
    assert!((pressure / 3e-6 / bulk - 1.0).abs() < 1e-4, "{pressure}");
    let turn = Quat::from_scaled_axis(Vec3::new(0.4, -0.7, 0.5));
    let back = turn.to_rotation_matrix().into_inner();
    let strain = Mat3::new(2e-6, 1e-6, 0.0, 1e-6, -1e-6, 0.5e-6, 0.0, 0.5e-6, 3e-6);
    let still = stress(of(&g), Quat::identity(), &strain);
    let turned = of(&(g * back.transpose()));
    let found = stress(turned, turn, &(back * strain * back.transpose()));
    let miss = (back.transpose() * found * back - still).amax() / still.amax();
    println!("C7, G: turned with the body, stress off by {miss:.1e}");
    assert!(miss < 1e-3, "{miss}");
    let strength = BondAnisotropy::of_matrix(&g);
    assert!((strength.strength - 0.95 / 1.4).abs() < 1e-9 && strength.axis.x.abs() > 0.999);
}

/// Strength by direction: a plane across the weak axis costs 7/12 of G_f at a ratio of ½, one along
/// it 25/32: the means of (1 − (n·a)²/2)² over the bonds that cross.
#[test]
fn c7_planes_cost_what_the_strength_of_their_bonds_says() {
    let anisotropy = BondAnisotropy { quartic: isotropic(), axis: Vec3::x(), strength: 0.5 };
    let weak = PeridynamicLaw { anisotropy: Some(anisotropy), ..glass(0.25, 0.0) };
    for (normal, due) in [(Vec3::x(), 7.0 / 12.0), (Vec3::y(), 25.0 / 32.0)] {
        let [cost, even] = [weak, glass(0.25, 0.0)].map(|law| opened(4.0, law, normal));
        println!("C7, strength: {:?} costs {cost:.3} G_f, due {due:.3}", normal.as_slice());
        assert!((cost / even / due - 1.0).abs() < 0.05, "{normal}: {cost} of {even}, due {due}");
    }
}
