//! Second tries and detectors, with steps that no problem can ask for.

use super::Brittle;
use cullet_fragment::cut::Partition;
use cullet_fragment::grid_bias::GridBias;
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{
    BrittleProblem, EnergyBalance, Failure, Fragmentation, Impact, Material, PointPrecision,
    Progress, Settings, Solver, StrengthField, SurfaceLaw,
};
use std::sync::Arc;

const PLASTER: Material = Material {
    density: 1100.0,
    young: 4e9,
    poisson: 0.2,
    failure_stress: 2e6,
    fracture_energy: 10.0,
};

/// A bar of 20 × 5 × 5 cm that is hit on its end.
fn struck(material: Material) -> Brittle {
    with(material, 1.0, Settings::default())
}

/// The same hit so many times as fast, with settings, but for the spacing.
fn with(material: Material, faster: f64, settings: Settings) -> Brittle {
    let size = Vec3::new(0.2, 0.05, 0.05);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a bar");
    let impact = Impact {
        point: Vec3::new(-0.1, 0.0, 0.0),
        normal: Vec3::x(),
        impulse: 0.2 * faster,
        duration: 5e-5,
        radius: 0.01,
        energy: 0.5 * faster * faster,
        closing_speed: 5.0 * faster,
        crushing_pressure: 1e12,
    };
    let settings = Settings { spacing: Some(0.01), ..settings };
    let solid = Arc::new(Solid::outer(mesh));
    let (impacts, supports, spin) = (vec![impact], Vec::new(), Vec3::zeros());
    let strength = StrengthField::default();
    let surface = SurfaceLaw::of(&material);
    let problem = BrittleProblem {
        solid,
        material,
        strength,
        surface,
        impacts,
        supports,
        spin,
        settings,
        seed: 1,
    };
    Brittle::begin(problem.into()).expect("a solve")
}

fn end(mut solve: Brittle) -> Result<Fragmentation, Failure> {
    loop {
        match solve.advance() {
            Progress::Running(_) => {}
            Progress::Done(outcome) => return Ok(outcome.fracture().expect("a fracture")),
            Progress::Failed(failure) => return Err(failure),
        }
    }
}

fn told(fracture: &Fragmentation, what: &str) -> bool {
    fracture.report.warnings.iter().any(|line| line.contains(what))
}

/// F76: a step beyond its bound ends as unstable; the second try has half of the one that should
/// have held, and says so.
#[test]
fn an_unstable_solve_is_tried_again_with_half_the_step() {
    let good = end(struck(PLASTER)).expect("it holds");
    assert!(!told(&good, "(F76)"), "{:?}", good.report.warnings);
    let mut wild = struck(PLASTER);
    let step = wild.domain.step;
    wild.domain.step *= 2.5;
    let again = end(wild).expect("the second try holds");
    assert!(told(&again, &format!("steps of {:.3e} s (F76)", 0.5 * step)), "{:?}", again.report);
    assert!(again.report.steps > good.report.steps * 3 / 2, "{} steps", again.report.steps);
    let mut single =
        with(PLASTER, 1.0, Settings { precision: PointPrecision::Single, ..Settings::default() });
    single.domain.step *= 2.5;
    let again = end(single).expect("the second try holds");
    assert!(told(&again, "s, in f64 (F76)"), "{:?}", again.report);
    // Where no try is left the failure is reported.
    let mut last = struck(PLASTER);
    last.setup.halvings = super::HALVINGS;
    last.domain.step *= 2.5;
    assert!(matches!(end(last), Err(Failure::Unstable { .. } | Failure::NotFinite { .. })));
}

/// A solve whose error need not be small ends once little breaks any more, not before the push is
/// over, and when nearly all is broken that would have been.
#[test]
fn a_solve_ends_when_too_little_breaks_to_matter() {
    let whole = end(with(PLASTER, 5.0, Settings::default())).expect("it holds");
    let short = |error: f64| {
        let settings = Settings { error: Some(error), ..Settings::default() };
        end(with(PLASTER, 5.0, settings)).expect("it holds")
    };
    let (half, tenth) = (short(0.5), short(0.1));
    let time = [&half, &tenth, &whole].map(|one| one.report.simulated);
    assert!(time[0] < 0.7 * time[2] && time[0] <= time[1] && time[1] < time[2], "{time:?}");
    let [longer, long, usual] =
        [&half, &tenth, &whole].map(|one| one.report.simulated / one.report.steps as f64);
    assert!((longer / usual - 1.25).abs() < 1e-9 && (long / usual - 1.05).abs() < 1e-9);
    assert!(told(&half, "an error of 0.5") && !told(&whole, "an error of"), "{:?}", half.report);
    let broken = [&half, &tenth, &whole]
        .map(|one| one.report.detail("damaged_fraction").unwrap_or_default());
    assert!(broken[0] > 0.95 * broken[2] && broken[1] > 0.95 * broken[2], "{broken:?}");
    let share = half.report.detail("delivered_impulse").unwrap_or_default()
        / whole.report.detail("delivered_impulse").unwrap_or_default();
    assert!((share - 1.0).abs() < 1e-3, "cut short in the push: {share}");
}

/// What has parted is looked at more rarely where an error is good enough.
#[test]
fn a_tolerance_reaches_the_domain() {
    let refresh = |error| {
        with(PLASTER, 1.0, Settings { error, ..Settings::default() }).domain.crack_check_period()
    };
    assert_eq!([None, Some(0.5)].map(refresh), [4, 7]);
}

/// Growth is small when a sixteenth of the error of what is broken broke within a transit, and
/// never before a transit has passed or where a crack may still part what is not crushed.
#[test]
fn growth_is_small_beside_what_has_broken() {
    let small = |broken: &[u32], error: f64| {
        let mut growth = super::CrackActivity::default();
        for (step, &count) in broken.iter().enumerate() {
            growth.note(step as f64, count, 400.0, 4.0);
        }
        let share = Settings { error: Some(error), ..Settings::default() }.tolerance().growth();
        growth.is_small(share.expect("an error"), 400.0)
    };
    let after = |count| [0, 100, 100, 100, 100, count];
    assert!(small(&after(103), 0.5) && !small(&after(104), 0.5) && small(&after(104), 1.0));
    assert!(!small(&[100, 100, 100], 1.0), "before a transit");
    assert!(!small(&[0; 9], 1.0) && !small(&[0, 99, 99, 99, 99, 99], 1.0), "not crushed");
    assert!(!small(&[0, 0, 0, 0, 200, 202, 202, 202], 1.0));
}

/// F06: a point that broke before the wave from the contact can have come to it is reported; one
/// that broke when the wave was there, or beside the contact, is not.
#[test]
fn what_breaks_ahead_of_sound_is_told() {
    let mut solve = struck(PLASTER);
    let far = solve.domain.particles.reference.iter().position(|x| x.x > 0.09).expect("an end");
    let near = solve.domain.particles.reference.iter().position(|x| x.x < -0.09).expect("an end");
    for p in [near, far] {
        solve.domain.particles.damage[p] = 1.0;
        solve.domain.particles.damage_time[p] = 1e-5;
    }
    // 19 cm away, less the disc of 2 cells, three cells and 1.1 times the way of 10 µs.
    let x = solve.domain.particles.reference[far] - solve.loads[0].point;
    let lead = x.norm() - 0.02 - 0.03 - 1.1e-5 * PLASTER.pressure_speed();
    let found = solve.ahead();
    assert!(found.0 == 1 && (found.1 - lead).abs() < 1e-9 && lead > 0.05, "{found:?}, {lead}");
    let report = solve.report(&[]);
    assert!(report.warnings.iter().any(|line| line.contains("(F06)")), "{:?}", report.warnings);
    solve.domain.particles.damage_time[far] = 0.2 / PLASTER.pressure_speed();
    assert_eq!(solve.ahead(), (0, 0.0));
}

/// F09, F10: damage that was taken back and momentum that nothing gave are reported at the end.
#[test]
fn what_the_watch_finds_is_told() {
    let told = |solve: &Brittle, mode: &str| {
        solve.report(&[]).warnings.iter().any(|line| line.contains(mode))
    };
    let mut solve = struck(PLASTER);
    (0..16).for_each(|_| solve.step().expect("a step"));
    solve.check().expect("numbers");
    assert!(!told(&solve, "(F09)") && !told(&solve, "(F10)"));
    for damage in [0.5, 0.4] {
        solve.domain.particles.damage[0] = damage;
        solve.check().expect("numbers");
    }
    assert!(told(&solve, "(F09)") && !told(&solve, "(F10)"));
    solve.domain.launch(|_| Vec3::zeros());
    solve.check().expect("numbers");
    assert!(told(&solve, "(F10)"));
}

/// F04: of what the hits have, 2 % that nothing gave end a solve, before and after the hits began
/// to give; what is missing is told from 5 % on.
#[test]
fn energy_that_nothing_gave_ends_a_solve() {
    let mut solve = struck(PLASTER);
    (0..16).for_each(|_| solve.step().expect("a step"));
    let [off, energy, broken] = [solve.record.balance.off, 0.5, solve.record.total.dissipated];
    assert!(off.abs() < 1e-3, "{off}");
    solve.record.total.dissipated += 0.015 * energy;
    solve.check().expect("a little");
    solve.record.total.dissipated += 0.01 * energy;
    let made = solve.check();
    assert!(matches!(made, Err(Failure::Unstable { .. })), "{made:?}");
    for (missing, told) in [(0.049, false), (0.052, true)] {
        solve.record.total.dissipated = broken - missing * energy;
        solve.record.balance = EnergyBalance::default();
        solve.check().expect("none is made");
        let lines = solve.report(&[]).warnings;
        assert_eq!(lines.iter().any(|line| line.contains("energy is off by -")), told, "{lines:?}");
    }
}

/// F22: faces in the grid's planes are reported with how often, faces of all directions are not.
#[test]
fn faces_that_lie_along_the_grid_are_told() {
    let cracked = |mesh: cullet_geometry::TriMesh| {
        let surface = vec![cullet_geometry::Surface::crack(0.0); mesh.triangles.len()];
        Solid { surface, ..Solid::outer(mesh) }
    };
    let size = Vec3::repeat(0.1);
    let cube = cracked(shapes::cuboid(size, shapes::Detail::default()).expect("a cube"));
    let told = super::warnings::grid_bias_warning([&cube].into_iter()).expect("it leans");
    // 1 / 3 (1 − cos 10°).
    assert!(told.contains("21.9 times as often as chance (F22)"), "{told}");
    let ball = cracked(shapes::sphere(0.1, shapes::Detail::default()).expect("a ball"));
    assert_eq!(super::warnings::grid_bias_warning([&ball].into_iter()), None);
    assert_eq!(super::warnings::grid_bias_warning([&Solid::outer(cube.mesh)].into_iter()), None);
}

/// F22: a cut whose faces show the grid is not handed out; its name says how often they do.
#[test]
fn a_cut_that_shows_the_grid_is_none() {
    let bias = |times: f64, elsewhere: f64| GridBias { times, elsewhere, solved: 1.5 };
    let shown = |bias: GridBias| {
        super::may_be_shown(Partition { bias, ..Partition::default() }).map_err(|e| e.to_string())
    };
    let why = shown(bias(10.4, 4.0)).expect_err("a staircase");
    assert!(why.contains("10.4 times as often as chance (F22)"), "{why}");
    assert!(shown(bias(1.9, 1.0)).is_ok() && shown(bias(21.9, 21.9)).is_ok());
}
