//! The points' pass: the same bits with all instructions of the processor and any number of
//! threads; f32 beside f64.

use cullet_fracture::brittle::{Brittle, TerminationCriteria};
use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::Domain;
use cullet_fracture::mpm::stencil::vector;
use cullet_fracture::particles::Particles;
use cullet_geometry::{Solid, Vec3, math::unit, shapes};
use cullet_model::{
    BrittleProblem, Fragmentation, Impact, Material, PointPrecision, Progress, Settings, Solver,
    StrengthField, SurfaceLaw,
};
use cullet_simd::SimdLevel;
use std::sync::Arc;

const SPACING: f64 = 0.01;

const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 10.0,
};

/// A block with a notch, pulled apart and sheared so `fiercely` that cracks run and part it.
fn block(precision: PointPrecision, level: SimdLevel, fiercely: f64) -> Domain {
    let cells = [12, 10, 6];
    let points: Vec<Vec3> = (0..8 * cells[0] * cells[1] * cells[2])
        .map(|i| {
            let half = [i / (4 * cells[1] * cells[2]), i / (2 * cells[2]) % (2 * cells[1])];
            let half = [half[0], half[1], i % (2 * cells[2])];
            Vec3::from([0, 1, 2].map(|a| {
                let jitter = unit(3, a as u64, i as u64);
                0.5 * SPACING * (half[a] as f64 - cells[a] as f64 + jitter)
            }))
        })
        .collect();
    let volume = 1e-6 * (cells[0] * cells[1] * cells[2]) as f64;
    let mut particles = Particles::at_rest(&points, volume, STONE.density);
    for (p, strength) in particles.strength.iter_mut().enumerate() {
        *strength = 0.8 + 0.4 * unit(9, 0, p as u64);
    }
    let law = Softening::on_grid(&STONE, SPACING);
    let mut domain = Domain::new(particles, &STONE, law, Vec3::repeat(SPACING));
    domain.select(precision, level);
    domain.sever(|a, b| a.y < -0.03 && b.y < -0.03 && a.x < 0.0 && b.x >= 0.0);
    domain.launch(|x| Vec3::new(8.0 * x.x, -2.0 * x.z, 2.0 * x.x + x.y) * fiercely);
    domain
}

/// Damage and displacement by id.
fn state(domain: &Domain) -> Vec<(f64, Vec3)> {
    let motions = domain.motions();
    let slots = (0..domain.particles.len() as u32).map(|id| domain.slot(id));
    slots.map(|p| (domain.particles.damage[p], motions[p].displacement)).collect()
}

#[test]
fn the_bits_depend_neither_on_the_path_nor_on_the_threads() {
    for precision in [PointPrecision::Single, PointPrecision::Double] {
        let run = |level: SimdLevel, threads: usize| {
            let mut domain = block(precision, level, 3.0);
            let whole = domain.grid.nodes.len();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let lost: f64 = pool
                .expect("a pool")
                .install(|| (0..150).map(|_| domain.advance().dissipated).sum());
            assert!(domain.grid.nodes.len() > whole + 100, "cracks part nodes");
            let nodes = domain.grid.nodes.velocity.iter().map(|v| vector(*v).map(f64::to_bits));
            let damage: Vec<u64> = domain.particles.damage.iter().map(|c| c.to_bits()).collect();
            (nodes.collect::<Vec<_>>(), damage, lost.to_bits())
        };
        let wanted = run(SimdLevel::portable(), 1);
        for level in SimdLevel::all() {
            for threads in [1, 3] {
                assert!(
                    wanted == run(level, threads),
                    "{precision:?} on {level}, {threads} threads"
                );
            }
        }
    }
}

/// A whole solve of a plaster block: fragments, their motion and the report.
fn solve(precision: PointPrecision, level: SimdLevel, threads: usize) -> Fragmentation {
    let plaster = Material {
        density: 1150.0,
        young: 3e9,
        poisson: 0.2,
        failure_stress: 3e6,
        fracture_energy: 5.0,
    };
    let impact = Impact {
        point: Vec3::new(-0.1, 0.02, 0.03),
        normal: Vec3::x(),
        impulse: 12.0,
        duration: 1.2e-4,
        radius: 6e-3,
        energy: 120.0,
        closing_speed: 20.0,
        crushing_pressure: 1e12,
    };
    let mesh = shapes::cuboid(Vec3::repeat(0.2), shapes::Detail::default()).expect("a block");
    let problem = BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material: plaster,
        strength: StrengthField { seed: 7, ..StrengthField::default() },
        surface: SurfaceLaw::of(&plaster),
        impacts: vec![impact],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings { max_particles: 2500, precision, ..Settings::default() },
        seed: 7,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| {
        let mut run =
            Brittle::with(problem, TerminationCriteria::default(), level).expect("accepted");
        loop {
            match run.advance() {
                Progress::Running(_) => {}
                Progress::Done(outcome) => return outcome.fracture().expect("a fracture"),
                Progress::Failed(failure) => panic!("{failure}"),
            }
        }
    })
}

#[test]
fn a_solve_has_the_same_bits_on_every_path_and_with_any_number_of_threads() {
    let [single, double] = [PointPrecision::Single, PointPrecision::Double].map(|precision| {
        let wanted = solve(precision, SimdLevel::portable(), 1);
        assert!(wanted.fragments.len() > 3, "{} fragments", wanted.fragments.len());
        for level in SimdLevel::all() {
            let found = solve(precision, level, 3);
            assert!(wanted == found, "{precision:?} on {level}");
        }
        wanted
    });
    assert!(single != double, "the setting is heard");
}

/// Displacements within three thousandths of the greatest, damage within a hundredth, energy to
/// 2e-5.
#[test]
fn single_stays_near_double() {
    let level = SimdLevel::best();
    let (mut single, mut double) =
        (block(PointPrecision::Single, level, 1.3), block(PointPrecision::Double, level, 1.3));
    let (mut lost, mut broken) = ([0.0; 2], [0; 2]);
    for _ in 0..200 {
        for (k, domain) in [&mut single, &mut double].into_iter().enumerate() {
            let tally = domain.advance();
            lost[k] += tally.dissipated;
            broken[k] += tally.broken;
        }
    }
    let (a, b) = (state(&single), state(&double));
    let size = b.iter().map(|(_, u)| u.norm()).fold(0.0, f64::max);
    let far = a.iter().zip(&b).map(|(a, b)| (a.1 - b.1).norm()).fold(0.0, f64::max) / size;
    let damage = a.iter().zip(&b).map(|(a, b)| (a.0 - b.0).abs()).fold(0.0, f64::max);
    let energy = (lost[0] / lost[1] - 1.0).abs();
    eprintln!("u {far:e} damage {damage:e} lost {lost:?} broken {broken:?}");
    assert!((200..3000).contains(&broken[1]), "{} of {} broken", broken[1], b.len());
    assert!(far > 0.0 && far < 3e-3, "displacements apart by {far}");
    assert!(damage < 1e-2, "damage apart by {damage}");
    assert!(energy < 2e-5, "energy apart by {energy}");
    assert_eq!(broken[0], broken[1]);
}

/// Nodes that hardly see a point have forces that are mostly rounding: in f32 they stay as slow as
/// in f64, and none runs so far that its elements lose their strain (F04).
#[test]
fn light_nodes_do_not_run_away_in_single() {
    let fastest = |precision| {
        let mut domain = block(precision, SimdLevel::best(), 3.0);
        (0..600).map(|_| domain.advance().fastest.sqrt()).fold(0.0, f64::max)
    };
    let (single, double) = (fastest(PointPrecision::Single), fastest(PointPrecision::Double));
    assert!(single < 3.0 * double, "{single:.0} m/s in f32, {double:.0} m/s in f64");
}
