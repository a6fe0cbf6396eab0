//! Gates 3 to 6: the worked examples of the catalogue, and what a plan does with them.

use crate::common;

use common::*;
use cullet_geometry::Vec3;
use cullet_model::Material;
use cullet_plan::RigidReason;
use cullet_plan::brittle::{
    AccuracyTarget, Figures, Regime, SolveLimits, SolvePlan, SpacingBound, Statistics, cost,
    estimate, grady_size, ladder_error, pieces_of_energy, plan, regime, softening_spacing,
    statistics, thickness_points,
};
use cullet_world::{BodyMeasure, Hit, World};

fn near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found / wanted - 1.0).abs() < tolerance, "{found}, not {wanted}");
}

const CONCRETE: Material = Material {
    density: 2400.0,
    young: 32e9,
    failure_stress: 3e6,
    fracture_energy: 100.0,
    ..GLASS.solid
};

/// Gate 3: a steel ball on 10 mm of glass, 92 µs against 3.6 µs there and back.
#[test]
fn a_ball_on_a_plate_is_static_through_its_thickness() {
    let speed = 0.02 / 3.6e-6;
    let (ratio, found) = regime(92e-6, 0.01, speed);
    near(ratio, 92.0 / 3.6, 1e-9);
    assert_eq!(found, Regime::Static);
    assert_eq!(regime(92e-6, 0.1, speed).1, Regime::Dynamic);
    assert_eq!(regime(92e-6, 1.0, speed).1, Regime::Wave);
}

/// Gate 4: 86 thousand points at L/t = 20, half a million at 50, the thesis' glass at 70.
#[test]
fn thin_plates_cost_points_by_the_square() {
    for (slenderness, points) in [(20.0, 86.4e3), (50.0, 0.54e6), (70.0, 1.06e6), (100.0, 2.16e6)] {
        near(thickness_points(slenderness * slenderness, 1.0, 3.0), points, 0.01);
    }
}

/// Gate 5: glass at 10³ and 10⁴ /s, concrete at 10² and 10³ /s.
#[test]
fn gradys_sizes_are_those_of_the_catalogue() {
    let glass = Material { fracture_energy: 8.0, density: 2440.0, ..GLASS.solid };
    for (material, rate, size) in [
        (glass, 1e3, 4.3e-3),
        (glass, 1e4, 0.92e-3),
        (CONCRETE, 1e2, 46e-3),
        (CONCRETE, 1e3, 10e-3),
    ] {
        near(grady_size(&material, rate), size, 0.02);
    }
}

/// Gate 1: what a glass marble of 5.4 g takes to become 10, 100 and 1000 pieces.
#[test]
fn what_pieces_of_a_marble_cost_is_what_the_catalogue_says() {
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.008_f64.powi(3);
    for (count, energy) in [(10.0, 3.7e-3), (100.0, 11.7e-3), (1000.0, 29e-3)] {
        near(pieces_of_energy(volume, energy, 8.0), count, 0.03);
    }
    assert_eq!(pieces_of_energy(volume, 0.0, 8.0), 1.0);
}

/// Gate 5: one cut below two pieces; fines beyond two hundred that the grid cannot tell apart.
#[test]
fn few_pieces_are_a_cut_and_many_small_ones_are_fines() {
    assert_eq!(statistics(1.9, 0.1, 1e-3), Statistics::Cut);
    assert_eq!(statistics(2.0, 0.1, 1e-3), Statistics::Solved);
    assert_eq!(statistics(200.0, 1e-3, 1e-3), Statistics::Solved);
    assert_eq!(statistics(201.0, 3.9e-3, 1e-3), Statistics::Fines);
    assert_eq!(statistics(201.0, 4.1e-3, 1e-3), Statistics::Solved);
}

/// Gate 6: l_max = 711 mm of concrete and 0.448 mm of glass, a fifth of it; and h⁻⁴.
#[test]
fn the_spacing_that_keeps_the_strength_and_what_it_costs() {
    near(softening_spacing(&CONCRETE, 4.0), 0.2 * 0.711, 0.01);
    let glass = Material { young: 70e9, failure_stress: 50e6, fracture_energy: 8.0, ..GLASS.solid };
    near(softening_spacing(&glass, 4.0), 0.2 * 0.448e-3, 0.01);
    let (points, steps, coarse) = cost(1e-3, 1e-4, 5000.0, 2e-3);
    near(points, 8e-3 / 8e-9, 1e-12);
    near(steps, 0.5 / 0.8e-3, 1e-12);
    near(cost(1e-3, 1e-4, 5000.0, 1e-3).2 / coarse, 16.0, 1e-12);
    near(ladder_error(12.0), 0.3, 1e-12);
    near(ladder_error(36.0), 0.1, 1e-12);
}

/// A cube of glass of 10 cm, hit on its face by a ball of steel at 20 m/s.
fn struck() -> (Hit, BodyMeasure) {
    let mut world = World::new(weightless()).unwrap();
    let size = Vec3::repeat(0.1);
    let cube = put(&mut world, body("cube", cuboid(size), GLASS, Vec3::zeros()));
    let ball = body("ball", sphere(0.01, 6), STEEL, Vec3::new(0.0, 0.0, 0.1));
    put(&mut world, cullet_world::BodySpec { velocity: -Vec3::z() * 20.0, ..ball });
    let hits = until_hit(&mut world, 60);
    let hit = hits.into_iter().find(|hit| hit.body == cube).unwrap();
    let (solid, _) = cuboid(size);
    (hit, BodyMeasure::of(&solid, 1e-3, 1.0, 0))
}

const FREE: SolveLimits = SolveLimits { most_points: 1e9, most_steps: 1e9, finest: 0.0 };

fn planned(
    need: &AccuracyTarget,
    frame: &SolveLimits,
    change: impl Fn(&mut BodyMeasure),
) -> Result<SolvePlan, RigidReason> {
    let (hit, mut body) = struck();
    change(&mut body);
    plan(&hit, &GLASS.solid, &body, need, frame)
}

#[test]
fn what_is_asked_decides_the_spacing_and_the_plan_says_what_did() {
    let same = |_: &mut BodyMeasure| {};
    let of = |need: AccuracyTarget| planned(&need, &FREE, same).unwrap();
    // A section of 10 cm across: 36 cells for 10 %, 12 for 30 %.
    let tenth = of(AccuracyTarget { error: Some(0.1), ..AccuracyTarget::default() });
    near(tenth.spacing, 0.1 / 36.0, 1e-9);
    assert_eq!(tenth.bound, SpacingBound::Error);
    near(tenth.error, 0.1, 1e-9);
    near(
        of(AccuracyTarget { error: Some(0.3), ..AccuracyTarget::default() }).spacing,
        0.1 / 12.0,
        1e-9,
    );
    let small = of(AccuracyTarget { smallest: Some(8e-3), ..AccuracyTarget::default() });
    near(small.spacing, 2e-3, 1e-9);
    assert_eq!(small.bound, SpacingBound::Smallest);
    // Both: the finer.
    let both =
        of(AccuracyTarget { error: Some(0.1), smallest: Some(8e-3), ..AccuracyTarget::default() });
    assert_eq!(both, small);
    // Four fifths of a cube lie less than 0.207 of its edge deep: three cells and a margin.
    let rough = of(AccuracyTarget { error: Some(1.0), ..AccuracyTarget::default() });
    near(rough.spacing, 2.5 * 0.207 * 0.1 / 3.3, 0.02);
    assert_eq!(rough.bound, SpacingBound::Thickness);
    // A budget coarsens: the cost comes out at it.
    let budget =
        of(AccuracyTarget { error: Some(0.1), budget: Some(0.5), ..AccuracyTarget::default() });
    assert_eq!(budget.bound, SpacingBound::Budget);
    near(budget.cost, 0.5, 1e-9);
    assert!(budget.spacing > tenth.spacing && budget.error > 0.1);
    let text = budget.to_string();
    assert!(text.contains("by the budget") && text.contains("0.50 s"), "{text}");
    // 0.75 · E G_f/σ_f² of this glass, far below: cracks run at their toughness, not the strength.
    near(budget.softening, softening_spacing(&GLASS.solid, 0.8 / 0.375), 1e-12);
    assert!(budget.spacing > budget.softening && text.contains("toughness-controlled"), "{text}");
    let fine = SolvePlan { spacing: 0.5 * budget.softening, ..budget };
    assert!(!fine.to_string().contains("toughness"), "{fine}");
    // So do the scene's most points, and the solve that the body comes from.
    let frame = SolveLimits { most_points: 1000.0, ..FREE };
    let few =
        planned(&AccuracyTarget { error: Some(0.3), ..AccuracyTarget::default() }, &frame, same);
    let Err(RigidReason::Thin { points, .. }) = few else { panic!("{few:?}") };
    // 3.3 cells of 0.519 of the edge: (3.3/0.519)³ cells of 8 points.
    near(points, 8.0 * (3.3_f64 / 0.519).powi(3), 0.05);
    let told = few.unwrap_err().to_string();
    assert!(told.contains(&format!("takes {points:.0} points")), "{told}");
    let frame = SolveLimits { finest: 5e-3, ..FREE };
    let parent =
        planned(&AccuracyTarget { error: Some(0.1), ..AccuracyTarget::default() }, &frame, same)
            .unwrap();
    assert_eq!((parent.spacing, parent.bound), (5e-3, SpacingBound::Parent));
    let steps = SolveLimits { most_steps: 300.0, ..FREE };
    let short =
        planned(&AccuracyTarget { error: Some(0.1), ..AccuracyTarget::default() }, &steps, same)
            .unwrap();
    assert_eq!(short.bound, SpacingBound::Steps);
    near(short.steps, 300.0, 1e-9);
}

/// Beyond its plan a body may be solved as finely as points, steps, pixels and the solve that made
/// it allow, whatever the budget; what broke from another not at all.
#[test]
fn a_plan_knows_how_fine_a_solve_may_become() {
    let need = AccuracyTarget { error: Some(0.1), budget: Some(0.5), ..AccuracyTarget::default() };
    let finest =
        |need: AccuracyTarget, frame: SolveLimits| planned(&need, &frame, |_| {}).unwrap().finest;
    let points = |most: f64| 0.1 * (8.0 / most).cbrt();
    let (spacing, by) = finest(need, FREE);
    near(spacing, points(1e9), 0.01);
    assert_eq!(by, SpacingBound::Points);
    assert_eq!(finest(need, SolveLimits { finest: 1e-3, ..FREE }), (1e-3, SpacingBound::Parent));
    let pixel = AccuracyTarget { pixel: Some(4e-3), ..need };
    assert_eq!(finest(pixel, SolveLimits { finest: 1e-3, ..FREE }), (2e-3, SpacingBound::Pixel));
    assert_eq!(finest(need, SolveLimits { most_steps: 300.0, ..FREE }).1, SpacingBound::Steps);
    let later = planned(&need, &FREE, |body| body.generation = 1).unwrap();
    assert_eq!(later.finest, (later.spacing, SpacingBound::Generation));
    assert_eq!(later.bound, SpacingBound::Budget, "{later}");
}

/// What a scene says that matters decides the spacing: the cone, the strength; and what the hit
/// is: a wave.
#[test]
fn the_contact_the_strength_and_a_short_wave_bound_the_spacing() {
    let (hit, body) = struck();
    let rough = AccuracyTarget { error: Some(1.0), ..AccuracyTarget::default() };
    let most = SolveLimits { most_points: 1e12, ..FREE };
    let of =
        |hit: &Hit, need: AccuracyTarget| plan(hit, &GLASS.solid, &body, &need, &most).unwrap();
    let cone = of(&hit, AccuracyTarget { cone: true, ..rough });
    near(cone.spacing, hit.impact.radius / 4.0, 1e-12);
    assert_eq!(cone.bound, SpacingBound::Cone);
    assert!(cone.to_string().contains("by the contact's radius"), "{cone}");
    let strong = of(&hit, AccuracyTarget { strength: true, ..rough });
    near(strong.spacing, softening_spacing(&GLASS.solid, 0.8 / 0.375), 1e-12);
    assert_eq!(strong.bound, SpacingBound::Strength);
    let text = strong.to_string();
    assert!(text.contains("by the strength") && !text.contains("toughness"), "{text}");
    // A tenth of the way there and back: spall.
    let mut short = hit.clone();
    let speed = GLASS.solid.pressure_speed();
    short.impact.duration = 0.1 * 2.0 * body.length / speed;
    let wave = of(&short, rough);
    assert_eq!((wave.regime, wave.bound), (Regime::Wave, SpacingBound::Wave));
    near(wave.spacing, 0.2 * body.length / 20.0, 1e-9);
    // A push of more than six transits is quasi-static: no more of it is followed.
    let mut long = hit.clone();
    long.impact.duration = 12.0 * body.length / speed;
    let held = of(&long, rough);
    assert_eq!(held.regime, Regime::Static);
    near(held.duration, 10.0 * body.length / GLASS.solid.shear_speed(), 1e-9);
    // What the energy cannot pay for is not counted.
    let mut weak = hit;
    weak.impact.energy = 0.02;
    let few = of(&weak, rough);
    let paid = pieces_of_energy(body.volume, 0.02, GLASS.solid.fracture_energy);
    assert!(1.0 < paid && paid < 2.0, "{paid}");
    assert_eq!(few.count, paid);
    assert!(few.to_string().contains("one cut would do"), "{few}");
}

/// The depth of plate, bar, cube and ball against what the points of a solve would say.
#[test]
fn thickness_is_what_a_solver_sees() {
    let of = |size: Vec3| BodyMeasure::of(&cuboid(size).0, size.product(), 1.0, 0).depth;
    near(of(Vec3::new(1.0, 1.0, 0.01)), 0.01, 0.03);
    // 1 − (1 − 2d/t)² = 0.8 and 1 − (1 − 2d/t)³ = 0.8.
    near(of(Vec3::new(0.02, 0.02, 1.0)), 2.5 * 0.2764 * 0.02, 0.05);
    near(of(Vec3::repeat(0.1)), 2.5 * 0.2076 * 0.1, 0.02);
    let ball = BodyMeasure::of(&sphere(0.1, 16).0, 4.0 / 3.0 * std::f64::consts::PI * 1e-3, 1.0, 0);
    near(ball.depth, 2.5 * 0.4152 * 0.1, 0.03);
}

#[test]
fn a_fragment_is_solved_a_level_lower_and_a_crumb_not_at_all() {
    let need = AccuracyTarget { error: Some(0.1), ..AccuracyTarget::default() };
    let first = planned(&need, &FREE, |_| {}).unwrap();
    let later = planned(&need, &FREE, |body| body.generation = 1).unwrap();
    near(later.spacing / first.spacing, 2.0, 1e-9);
    near(first.cost / later.cost, 16.0, 1e-9);
    let frame = SolveLimits { finest: 0.04, ..FREE };
    let crumb = planned(&need, &frame, |_| {});
    assert!(matches!(crumb, Err(RigidReason::Cells { cells, .. }) if cells < 27.0), "{crumb:?}");
    let text = crumb.unwrap_err().to_string();
    assert!(text.contains("15.6 cells of 4.000e-2 m, below 27"), "{text}");
}

/// Gate 0: what is smaller than two pixels is neither solved for nor resolved.
#[test]
fn nothing_is_resolved_that_no_pixel_shows() {
    let need = |pixel: f64| AccuracyTarget {
        error: Some(0.1),
        pixel: Some(pixel),
        ..AccuracyTarget::default()
    };
    let sharp = planned(&need(1e-3), &FREE, |_| {}).unwrap();
    assert_eq!(sharp.bound, SpacingBound::Error);
    // Four cells of two pixels of 8 mm.
    let coarse = planned(&need(8e-3), &FREE, |_| {}).unwrap();
    near(coarse.spacing, 4e-3, 1e-9);
    assert_eq!(coarse.bound, SpacingBound::Pixel);
    assert!(coarse.to_string().contains("by the pixel"), "{coarse}");
    // Halves of a cube of 10 cm are 5 cm across.
    let unseen = planned(&need(0.026), &FREE, |_| {});
    assert!(matches!(unseen, Err(RigidReason::Unseen { .. })), "{unseen:?}");
    let text = unseen.unwrap_err().to_string();
    assert!(text.contains("5.000e-2 m across, below two pixels, 5.200e-2 m"), "{text}");
}

#[test]
fn the_estimate_is_the_grid_convergence_index_at_first_order() {
    let figures = |spacing: f64, crack_area: f64, largest: f64| Figures {
        spacing,
        crack_area,
        largest,
        count: 2,
    };
    // 1.25 · 0.2 / (2 − 1) / 1.0 of the area, 1.25 · 0.1 / 0.5 of the largest.
    let found = estimate(&figures(2e-3, 1.2, 0.4), &figures(1e-3, 1.0, 0.5));
    near(found, 0.25, 1e-9);
    let found = estimate(&figures(2e-3, 1.0, 0.4), &figures(1e-3, 1.0, 0.5));
    near(found, 0.25, 1e-9);
    let whole = figures(1e-3, 0.0, 1.0);
    assert_eq!(estimate(&figures(2e-3, 0.0, 1.0), &whole), 0.0);
    assert!(estimate(&figures(2e-3, 0.0, 1.0), &figures(1e-3, 1.0, 0.5)) > 1.0);
}
