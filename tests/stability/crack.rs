//! Cracks and the fields on their sides: F03, F17 to F21, F28.

use crate::kit::{H, PLASTER, STRONG, body, rows, uneven};
use cullet_fracture::damage::{BAND_WIDTH, Softening};
use cullet_fracture::mpm::domain::{PrescribedVelocity, VelocityFields};
use cullet_fracture::mpm::load_patch::LoadPatch;
use cullet_fracture::mpm::stencil::Stencil;
use cullet_fracture::mpm::{Domain, quadrature};
use cullet_fracture::particles::Particles;
use cullet_geometry::{Vec3, inside::Inside, sample};
use cullet_model::Material;
use cullet_model::tolerance::REFRESH;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// As tough as the grid can tell it: its strength is not capped.
const TOUGH: Material = Material { fracture_energy: 500.0, ..PLASTER };

/// Brittler, as little capped: σ_f²h/2EG_f is 0.2.
const BRITTLE: Material = Material { fracture_energy: 75.0, ..PLASTER };

/// Energy that a crack through a notched bar spends, over G_f times the section that it parts.
fn spent(law: Softening, seed: u64) -> f64 {
    let size = Vec3::new(24.0, 12.0, 3.0) * H;
    let (half, notch, speed) = (0.5 * size.x, 4.0 * H, 0.15);
    let mesh = crate::kit::cuboid(size);
    let inside = Inside::new(&mesh);
    let points = sample::poisson(&inside, 0.5 * H, seed).expect("points");
    let mut particles = Particles::at_rest(&points, mesh.signed_volume(), BRITTLE.density);
    particles.volume = quadrature::volumes(&points, &inside, Vec3::repeat(H), mesh.signed_volume());
    for (p, x) in points.iter().enumerate() {
        particles.strength[p] = if x.x.abs() > 0.7 * half { 10.0 } else { 1.0 };
    }
    let mut domain = Domain::new(particles, &BRITTLE, law, Vec3::repeat(H));
    // A crack's tip is three quarters of a cell ahead of the last bond that is cut.
    let sawn = |x: &Vec3| x.y + 0.5 * size.y < notch - 0.75 * H;
    domain.sever(|a, b| a.x < 0.3 * H && b.x >= 0.3 * H && sawn(a) && sawn(b));
    let way = move |x: f64| Vec3::x() * (speed * (x / (0.9 * half)).clamp(-1.0, 1.0));
    domain.launch(|x| way(x.x));
    domain.prescribed =
        Some(PrescribedVelocity(Arc::new(move |x| (x.x.abs() > 0.9 * half).then(|| way(x.x)))));
    let (mut energy, mut parted) = (0.0, f64::INFINITY);
    while domain.time < 1.7 * parted && domain.steps < 20_000 {
        energy += domain.advance().dissipated;
        if parted.is_infinite() && domain.steps.is_multiple_of(16) && halves(&domain) == 2 {
            parted = domain.time;
        }
    }
    energy / ((size.y - notch) * size.z * BRITTLE.fracture_energy)
}

/// Pieces of more than a tenth of the points.
fn halves(domain: &Domain) -> usize {
    let mut counts = BTreeMap::new();
    domain.pieces().into_iter().flatten().for_each(|k| *counts.entry(k).or_insert(0) += 1);
    counts.values().filter(|&&n| n * 10 > domain.particles.len()).count()
}

/// F03: a crack spends G_f times its area, for the law is spread over the width of the band that
/// the grid smears it to. Spread over a spacing, it spends another multiple.
#[test]
fn f03_a_crack_spends_the_fracture_energy() {
    let right: Vec<f64> = (0..3).map(|seed| spent(Softening::on_grid(&BRITTLE, H), seed)).collect();
    let mean = right.iter().sum::<f64>() / 3.0;
    let wrong = spent(Softening::new(&BRITTLE, H), 0);
    println!("{right:?} of G_f; {wrong} where the band is a spacing, not {BAND_WIDTH}");
    // What is damaged beside the crack of a bar that is pulled so fast is counted with it.
    assert!((mean - 1.1).abs() < 0.15, "{right:?}");
    assert!(wrong > 1.5, "{wrong}");
}

/// A bar whose middle breaks as soon as it is pulled, when its halves have flown apart for a
/// while: how far they came over how far they would have.
fn halved(set: impl Fn(&mut Domain)) -> (f64, Domain) {
    let weak = |x: &Vec3| if x.x.abs() < 0.5 * H { 0.01 } else { 100.0 };
    let mut domain = uneven(&rows([10, 3, 3]), &TOUGH, weak);
    set(&mut domain);
    domain.launch(|x| Vec3::x() * x.x.signum());
    (0..200).for_each(|_| _ = domain.advance());
    let motions = domain.motions();
    let (mut way, mut count) = (0.0, 0.0);
    for (x, motion) in domain.particles.reference.iter().zip(&motions) {
        if x.x.abs() > 2.0 * H {
            way += motion.displacement.x * x.x.signum();
            count += 1.0;
        }
    }
    (way / count / domain.time, domain)
}

/// F17: with one field at each node the sides of a crack hold on to each other, and all that flew
/// apart is held back; with a field for each they let go.
#[test]
fn f17_two_fields_let_go_of_what_one_holds() {
    let (kept, domain) = halved(|_| {});
    assert!(kept > 0.6, "{kept} of the way");
    assert!(halves(&domain) == 2 && domain.splits() > 0);
    let (kept, domain) = halved(|domain| domain.fields = VelocityFields::Single);
    println!("one field: {kept} of the way");
    assert!(kept < 0.2 && domain.splits() == 0, "{kept} of the way");
}

/// F21: nodes part within a few steps of the crack, before its sides can hold each other back;
/// looked at late they do.
#[test]
fn f21_nodes_part_as_the_crack_runs() {
    let rayleigh = TOUGH.rayleigh_speed() * body(&rows([3, 3, 3]), &TOUGH).step;
    assert!(REFRESH as f64 * rayleigh < 2.0 * H, "a crack outruns its looks");
    let (kept, _) = halved(|_| {});
    let (late, _) = halved(|domain| domain.check_cracks_every(1000));
    println!("{kept} of the way, {late} where nodes part late");
    assert!(kept > 0.6 && late < 0.2, "{kept} and {late}");
}

/// What became of a bar whose halves had these speeds along it.
struct Met {
    /// Speeds of the halves along the bar \[m/s\].
    speeds: [f64; 2],
    /// Furthest that a side came into the other, in spacings.
    deep: f64,
    domain: Domain,
}

/// Sends the halves of a cut bar off, along it and across.
fn meet(along: f64, across: f64, steps: usize) -> Met {
    let mut domain = body(&rows([12, 2, 2]), &STRONG);
    domain.sever(|a, b| a.x < 0.0 && b.x > 0.0);
    domain.launch(|x| Vec3::new(along * x.x.signum(), across * x.x.signum(), 0.0));
    let beside = |side: f64| {
        let near = domain.particles.reference.iter().position(|x| (x.x / H - side).abs() < 0.1);
        domain.particles.id[near.expect("a point beside the cut")]
    };
    let sides = [-0.25, 0.25].map(beside);
    let mut deep = 0.0_f64;
    for _ in 0..steps {
        domain.advance();
        let motions = domain.motions();
        let [left, right] = sides.map(|id| motions[domain.slot(id)].displacement.x);
        deep = deep.max((left - right) / H);
    }
    let motions = domain.motions();
    let speeds = [-1.0, 1.0].map(|side| {
        let pairs = domain.particles.reference.iter().zip(&motions);
        let own: Vec<f64> =
            pairs.filter(|(x, _)| x.x * side > 0.0).map(|(_, m)| m.velocity.x).collect();
        own.iter().sum::<f64>() / own.len() as f64
    });
    Met { speeds, deep, domain }
}

/// F18: the sides of a crack that close push each other back and no deeper than a fifth of what
/// they would have gone, sides that part pull at nothing, and sides that slide do not hold.
#[test]
fn f18_sides_push_and_do_not_glue() {
    let speed = 10.0;
    let Met { speeds: [left, right], deep, domain } = meet(-speed, 0.0, 80);
    let free = 2.0 * speed * domain.time / H;
    println!("{left} and {right} m/s, {deep} of {free} cells deep");
    assert!(free > 0.5 && deep < 0.2 * free, "{deep} of {free}");
    assert!(left < -0.7 * speed && right > 0.7 * speed, "{left} and {right} m/s");
    assert!(domain.momentum().norm() < 1e-9 * domain.traffic(), "{}", domain.momentum());
    let Met { speeds: [left, right], .. } = meet(speed, 0.0, 60);
    assert!((left + speed).abs() < 1e-9 && (right - speed).abs() < 1e-9, "{left} and {right}");
    let slid = meet(0.0, 0.1 * speed, 20);
    let aside = slid.domain.motions();
    let pairs = slid.domain.particles.reference.iter().zip(&aside);
    let mean = pairs.map(|(x, m)| m.velocity.y * x.x.signum()).sum::<f64>() / aside.len() as f64;
    assert!((mean / (0.1 * speed) - 1.0).abs() < 1e-3, "{mean} m/s");
}

/// F21: what has met is two as before: it flies apart for good.
#[test]
fn f21_sides_that_met_stay_two() {
    let nodes = meet(1.0, 0.0, 0).domain.grid.nodes.len();
    let (soon, late) = (meet(-10.0, 0.0, 60), meet(-10.0, 0.0, 240));
    for met in [&soon, &late] {
        assert_eq!((met.domain.grid.nodes.len(), halves(&met.domain)), (nodes, 2));
    }
    assert!((late.speeds[1] / soon.speeds[1] - 1.0).abs() < 0.05, "{:?}", late.speeds);
}

/// The place of the `k`-th node that a point sees.
fn node(stencil: &Stencil, k: usize) -> [i32; 3] {
    let steps = [k / 9, k / 3 % 3, k % 3];
    std::array::from_fn(|axis| stencil.cell[axis] + steps[axis] as i32)
}

/// Gradient of damage at each point, in cells, as a method takes it that tells sides by that.
fn slopes(domain: &Domain) -> Vec<Vec3> {
    let (particles, spacing) = (&domain.particles, &domain.grid.spacing);
    let mut sums: BTreeMap<[i32; 3], (f64, f64)> = BTreeMap::new();
    for (x, damage) in particles.reference.iter().zip(&particles.damage) {
        let stencil = Stencil::new(x, spacing);
        stencil.visit(|k, weight, _| {
            let sum = sums.entry(node(&stencil, k)).or_default();
            *sum = (sum.0 + weight * damage, sum.1 + weight);
        });
    }
    let of = |x: &Vec3| {
        let (stencil, mut slope) = (Stencil::new(x, spacing), Vec3::zeros());
        stencil.visit(|k, weight, away| {
            let (damage, whole) = sums[&node(&stencil, k)];
            slope += away * (4.0 * weight * damage / whole);
        });
        slope
    };
    particles.reference.iter().map(of).collect()
}

/// A block whose layer |y| < `half` \[spacings\] is all broken, when its sides have flown apart,
/// and which of its points were in the layer.
fn torn(half: f64) -> (Domain, Vec<usize>) {
    let band = |x: &Vec3| if x.y.abs() < half * H { 0.01 } else { 100.0 };
    let mut domain = uneven(&rows([3, 12, 3]), &TOUGH, band);
    domain.launch(|x| Vec3::y() * (x.y / H));
    (0..100).for_each(|_| _ = domain.advance());
    let places = &domain.particles.reference;
    let inner = (0..places.len()).filter(|&p| places[p].y.abs() < half * H);
    let inner: Vec<u32> = inner.map(|p| domain.particles.id[p]).collect();
    assert!(inner.iter().all(|&id| domain.particles.damage[domain.slot(id)] >= 1.0));
    assert_eq!(halves(&domain), 2);
    domain.displace(|_| Vec3::zeros());
    domain.launch(|x| Vec3::y() * x.y.signum());
    (0..100).for_each(|_| _ = domain.advance());
    let slots = inner.into_iter().map(|id| domain.slot(id)).collect();
    (domain, slots)
}

/// F20: in a band of broken points four cells thick the gradient of damage tells no sides. None are
/// asked for there: no node sees across it, and broken points pull at nothing, so that its outer
/// layers fly with their sides. In a band of two cells, which nodes see across, broken points go
/// with the side that they are connected with.
#[test]
fn f20_the_sides_of_a_thick_band_are_told_by_connection() {
    let (thick, inner) = torn(2.0);
    let slopes = slopes(&thick);
    let blind = inner.iter().filter(|&&p| slopes[p].y.abs() < 0.05).count();
    assert!(blind * 5 > inner.len(), "{blind} of {} know no side by gradient", inner.len());
    assert_eq!(thick.splits(), 0);
    let motions = thick.motions();
    for (p, x) in thick.particles.reference.iter().enumerate().filter(|(_, x)| x.y.abs() > H) {
        let own = motions[p].velocity.y * x.y.signum();
        assert!(own > 0.5, "a point at {:.2} cells goes at {own} m/s", x.y / H);
    }
    let (thin, inner) = torn(1.0);
    assert!(thin.splits() > 0);
    let motions = thin.motions();
    for side in [1.0, -1.0] {
        let own = inner.iter().filter(|&&p| thin.particles.reference[p].y * side > 0.0);
        let speeds: Vec<f64> = own.map(|&p| motions[p].velocity.y * side).collect();
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        println!("broken points of side {side} go at {mean} m/s");
        assert!(mean > 0.5, "side {side}: {mean} m/s");
    }
}

/// Nodes that there are when each has been copied for every side that sees it.
fn copies(domain: &Domain, side: impl Fn(&Vec3) -> usize) -> usize {
    let mut seen: BTreeMap<[i32; 3], BTreeSet<usize>> = BTreeMap::new();
    for x in &domain.particles.reference {
        let stencil = Stencil::new(x, &domain.grid.spacing);
        stencil.visit(|k, _, _| {
            seen.entry(node(&stencil, k)).or_default().insert(side(x));
        });
    }
    seen.values().map(BTreeSet::len).sum()
}

/// F28: sides are connected sets, found by flooding: a body of two halves and one of three sectors
/// have as many copies of each node as sides see it, and two rooms with a door between them are
/// one. A walk that stops at the first wall would count more.
#[test]
fn f28_sides_are_connected_sets() {
    let parted = |cut: &dyn Fn(&Vec3, &Vec3) -> bool| {
        let mut domain = body(&rows([6, 6, 3]), &STRONG);
        let nodes = domain.grid.nodes.len();
        domain.sever(cut);
        let pieces: BTreeSet<Option<u32>> = domain.pieces().into_iter().collect();
        (domain, nodes, pieces.len())
    };
    let half = |x: &Vec3| usize::from(x.x > 0.0);
    let (domain, nodes, pieces) = parted(&|a, b| half(a) != half(b));
    assert_eq!((domain.grid.nodes.len(), pieces), (copies(&domain, half), 2));
    assert!(domain.grid.nodes.len() > nodes);
    let (domain, _, pieces) = parted(&|a, b| sector(a) != sector(b));
    assert_eq!((domain.grid.nodes.len(), pieces), (copies(&domain, sector), 3));
    // A wall with a door at one end: nodes that the door is in reach of are one.
    let (domain, nodes, pieces) = parted(&|a, b| half(a) != half(b) && a.y.min(b.y) < H);
    let all = copies(&domain, half);
    assert!((nodes + 1..all).contains(&domain.grid.nodes.len()) && pieces == 1, "{pieces}");
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
fn drag(fields: VelocityFields) -> f64 {
    let mut domain: Domain = body(&rows([6, 6, 2]), &STRONG);
    domain.fields = fields;
    if fields == VelocityFields::Split {
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
fn f19_three_pieces_at_a_junction_let_go_of_each_other() {
    let (split, single) = (drag(VelocityFields::Split), drag(VelocityFields::Single));
    assert!(split < 1e-9, "{split}");
    assert!(single > 0.1, "{single}");
}

/// F19: what presses on one side of a crack that opens under it goes on to see that side alone.
#[test]
fn f19_a_footing_stays_on_its_side_of_a_crack() {
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
        LoadPatch::new(under.into_iter().map(|id| (id, share)).collect())
    });
    let rest = feet.each_mut().map(|foot| foot.speed(&domain, &Vec3::x()));
    assert_eq!(rest, [0.0, 0.0]);
    domain.sever(|a, b| side(a.x) != side(b.x));
    domain.launch(|x| Vec3::x() * side(x.x));
    let [left, right] = feet.each_mut().map(|foot| foot.speed(&domain, &Vec3::x()));
    assert!((left + 1.0).abs() < 1e-12 && (right - 1.0).abs() < 1e-12, "{left} {right}");
}
