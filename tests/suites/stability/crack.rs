//! Points, grid and cracks: F15, F19.

use crate::kit::{H, STRONG, body, rows};
use cullet_fracture::mpm::Domain;
use cullet_fracture::mpm::domain::Fields;
use cullet_fracture::mpm::footing::Footing;
use cullet_fracture::mpm::kernel::vector;
use cullet_geometry::Vec3;

/// F15: stretched to three times its length a body is still one piece and bears what it is
/// stretched with: no point has left its kernel.
#[test]
fn a_threefold_stretch_parts_nothing() {
    let mut domain = body(&rows([6, 3, 3]), &STRONG);
    let count = domain.grid.nodes.len();
    domain.displace(|x| 2.0 * Vec3::x() * x.x);
    let stresses = domain.stresses();
    // P = F S, and S₁₁ = μ(1 − C⁻¹₁₁) + λ/2 (J² − 1) C⁻¹₁₁ with C₁₁ = J² = 9
    let wanted = STRONG.shear() * (1.0 - 1.0 / 9.0) + 0.5 * STRONG.lame() * 8.0 / 9.0;
    for stress in &stresses {
        assert!((stress[0] / wanted - 1.0).abs() < 1e-9, "{stress:?} of {wanted}");
    }
    domain.advance();
    // Σ m v x = −Δt V P₁₁, whichever nodes the points pull at.
    let nodes = &domain.grid.nodes;
    let places = (0..nodes.len()).map(|n| domain.grid.place(n).x);
    let pulls = nodes.velocity.iter().zip(&nodes.mass).zip(places);
    let pull: f64 = pulls.map(|((v, mass), x)| vector(*v).x * mass * x).sum();
    let volume: f64 = domain.particles.volume.iter().sum();
    let expected = -domain.step * volume * 3.0 * wanted;
    assert!((pull / expected - 1.0).abs() < 1e-9, "{pull} of {expected}");
    (0..7).for_each(|_| _ = domain.advance());
    assert_eq!(domain.grid.nodes.len(), count);
    assert!(domain.pieces().iter().all(|piece| *piece == Some(0)), "one piece");
}

/// The sector of a place around the z axis, of three.
fn sector(x: &Vec3) -> usize {
    let turn = libm::atan2(x.y, x.x) / std::f64::consts::TAU + 0.55;
    ((3.0 * turn) as usize).min(2)
}

/// Which way a sector goes.
fn away(sector: usize) -> Vec3 {
    let angle = std::f64::consts::TAU * ((sector as f64 + 0.5) / 3.0 - 0.55);
    Vec3::new(libm::cos(angle), libm::sin(angle), 0.0)
}

/// The greatest part of its speed that a point of three sectors lost, which fly apart.
fn drag(fields: Fields) -> f64 {
    let mut domain: Domain = body(&rows([6, 6, 2]), &STRONG);
    domain.fields = fields;
    if fields == Fields::Split {
        domain.sever(|a, b| sector(a) != sector(b));
    }
    domain.launch(|x| away(sector(x)));
    (0..40).for_each(|_| _ = domain.advance());
    let pairs = domain.particles.reference.iter().zip(domain.motions());
    pairs.map(|(x, motion)| (motion.velocity - away(sector(x))).norm()).fold(0.0, f64::max)
}

/// F19: where three cracks meet there are three fields: the pieces fly apart as if each were
/// alone. With one field they hold on to each other.
#[test]
fn three_pieces_at_a_junction_let_go_of_each_other() {
    let (split, single) = (drag(Fields::Split), drag(Fields::Single));
    assert!(split < 1e-9, "{split}");
    assert!(single > 0.1, "{single}");
}

/// F19: what presses on one side of a crack that opens under it goes on to see that side alone.
#[test]
fn a_footing_stays_on_its_side_of_a_crack() {
    let mut domain = body(&rows([6, 3, 3]), &STRONG);
    let side = |x: f64| 1.0_f64.copysign(x);
    let near: Vec<(u32, f64)> =
        (0..).zip(&domain.particles.reference).map(|(i, x)| (i, x.x)).collect();
    let mut feet = [-1.0, 1.0].map(|wanted| {
        let under: Vec<u32> = near
            .iter()
            .filter(|(_, x)| side(*x) == wanted && x.abs() < 0.6 * H)
            .map(|(i, _)| domain.particles.id[*i as usize])
            .collect();
        let share = 1.0 / under.len() as f64;
        Footing::new(under.into_iter().map(|id| (id, share)).collect())
    });
    let rest = feet.each_mut().map(|foot| foot.speed(&domain, &Vec3::x()));
    assert_eq!(rest, [0.0, 0.0]);
    domain.sever(|a, b| side(a.x) != side(b.x));
    domain.launch(|x| Vec3::x() * side(x.x));
    let [left, right] = feet.each_mut().map(|foot| foot.speed(&domain, &Vec3::x()));
    assert!((left + 1.0).abs() < 1e-12 && (right - 1.0).abs() < 1e-12, "{left} {right}");
}
