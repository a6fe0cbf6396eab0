//! One answer for all hits of a body: whether, by whom, how finely.

use crate::common;

use common::*;
use cullet_geometry::shapes::{Detail, lathe_midline};
use cullet_geometry::{Solid, Vec3};
use cullet_plan::{AccuracyTarget, Decision, Policy, SolveLimits, SolveOrder, decide, family};
use cullet_world::{BodyId, BodySpec, Hit, World};

/// A cube of glass of 10 cm on the floor, hit from above by a ball of steel at that speed.
fn struck(speed: f64) -> (World, BodyId, Vec<Hit>) {
    struck_body(Vec3::repeat(0.1), speed)
}

/// The same of a box of that size.
fn struck_body(size: Vec3, speed: f64) -> (World, BodyId, Vec<Hit>) {
    let mut world = World::new(weightless()).unwrap();
    put(&mut world, floor());
    let cube = body("cube", cuboid(size), GLASS, Vec3::z() * (0.5 * size.z));
    let cube = put(&mut world, cube);
    let ball = body("ball", sphere(0.02, 8), STEEL, Vec3::new(0.01, 0.0, 0.2));
    put(&mut world, BodySpec { velocity: -Vec3::z() * speed, breakable: false, ..ball });
    let hits = until_hit(&mut world, 240).into_iter().filter(|hit| hit.body == cube).collect();
    (world, cube, hits)
}

fn policy(target: Option<AccuracyTarget>, family: Option<&str>) -> Policy<'_> {
    let limits = SolveLimits { most_points: 1e9, most_steps: 1e9, finest: 0.0 };
    let weak_plane = false;
    let (treated, material, most_supports) = (false, "glass", 8);
    let yield_stress = None;
    Policy { target, family, weak_plane, treated, yield_stress, material, limits, most_supports }
}

fn order(speed: f64, policy: &Policy<'_>) -> SolveOrder {
    let (world, cube, hits) = struck(speed);
    match decide(&world, cube, &hits, policy) {
        Some(Decision::Solve(order)) => *order,
        other => panic!("{other:?}"),
    }
}

fn order_of_glass(name: &str) -> SolveOrder {
    order(5.0, &policy(None, Some(name)))
}

/// A metal that yields is solved as a shell where a sheet of it is hit on its face, as a solid
/// where a dent would be seen or it bends; else it is kept, with the reason of each hit.
#[test]
fn metal_is_solved_as_a_sheet_or_as_a_solid_or_kept() {
    let metal = Policy { yield_stress: Some(70e6), ..policy(None, None) };
    let asked = |size: Vec3, speed: f64| {
        let (world, body, hits) = struck_body(size, speed);
        decide(&world, body, &hits, &metal).expect("a body")
    };
    let sheet = Vec3::new(0.3, 0.2, 0.002);
    let Decision::Solve(order) = asked(sheet, 10.0) else { panic!("kept") };
    let other = Some(family::DUCTILE);
    assert_eq!((order.family.as_str(), order.fallback), (family::SHELL, other));
    assert!(!order.supports.is_empty());
    let words = |decision: Decision| {
        let Decision::Keep(reasons) = decision else { panic!("{decision:?}") };
        reasons.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    let slow = words(asked(sheet, 0.2));
    assert!(slow.contains("below 0.5 of that at which the metal yields, 7.000e7 Pa"), "{slow}");
    let Decision::Solve(order) = asked(Vec3::repeat(0.1), 10.0) else { panic!("kept") };
    assert_eq!((order.family.as_str(), order.fallback), (family::DUCTILE, None));
    assert!(order.reasons[0].contains("a dent of about"), "{:?}", order.reasons);
    let Decision::Solve(order) = asked(Vec3::new(0.5, 0.05, 0.05), 2.0) else { panic!("kept") };
    assert!(order.reasons[0].contains("it bends: "), "{:?}", order.reasons);
    let block = words(asked(Vec3::repeat(0.1), 0.3));
    assert!(block.contains("a dent of about") && block.contains("bends nothing"), "{block}");
    // Points and bonds are for whom a scene names them, and hand over to the solid.
    let bonded = Policy { family: Some(family::PERIDYNAMICS), ..metal };
    for size in [sheet, Vec3::repeat(0.1)] {
        let (world, body, hits) = struck_body(size, 10.0);
        let order = decide(&world, body, &hits, &bonded);
        let Some(Decision::Solve(order)) = order else { panic!("kept") };
        assert_eq!(
            (order.family.as_str(), order.fallback, order.choice()),
            (family::PERIDYNAMICS, Some(family::DUCTILE), Some("the scene's choice"))
        );
    }
    let order = order_of_glass(family::PERIDYNAMICS);
    assert_eq!(
        (order.family.as_str(), order.fallback, order.choice()),
        (family::PERIDYNAMICS, Some(family::SAMPLED), Some("the scene's choice"))
    );
    // A scene may ask for the solid of a sheet.
    let solid = Policy { family: Some(family::DUCTILE), ..metal };
    let (world, body, hits) = struck_body(sheet, 10.0);
    let Some(Decision::Solve(order)) = decide(&world, body, &hits, &solid) else { panic!("kept") };
    assert_eq!(
        (order.family.as_str(), order.choice()),
        (family::DUCTILE, Some("the scene's choice"))
    );
}

#[test]
fn what_cannot_crack_is_kept_with_a_reason_for_each_hit() {
    let (world, cube, hits) = struck(0.3);
    let decision = decide(&world, cube, &hits, &policy(None, None));
    let Some(Decision::Keep(reasons)) = decision else { panic!("{decision:?}") };
    assert_eq!(reasons.len(), hits.len());
    assert!(decide(&world, BodyId(99), &hits, &policy(None, None)).is_none(), "no such body");
}

#[test]
fn the_default_family_is_asked_and_the_sampled_one_stands_by() {
    let order = order(30.0, &policy(None, None));
    assert_eq!((order.family.as_str(), order.fallback), (family::DEFAULT, Some(family::SAMPLED)));
    assert_eq!(order.choice(), None);
    assert!(order.reasons.iter().all(|reason| reason.starts_with("held at ")), "{order:?}");
    let mut refinement = order.refinement;
    assert_eq!(refinement.climb(), None, "no accuracy was asked for");
}

#[test]
fn a_target_gives_a_plan_and_its_spacings() {
    let target = AccuracyTarget { error: Some(0.05), ..AccuracyTarget::default() };
    let order = order(30.0, &policy(Some(target), None));
    assert!(order.reasons.iter().any(|reason| reason.contains("by the error asked for")));
    let mut refinement = order.refinement;
    let first = refinement.climb().expect("a spacing");
    assert!(refinement.goes_on() && first > 0.0, "{first}");
    // What is too small to be seen is not worth a solve: its fragments are sampled.
    let unseen = AccuracyTarget { pixel: Some(0.1), ..target };
    let order = self::order(30.0, &policy(Some(unseen), None));
    assert_eq!((order.family.as_str(), order.fallback), (family::SAMPLED, None));
    assert!(order.reasons[0].contains("below two pixels"), "{:?}", order.reasons);
}

#[test]
fn the_scene_may_name_a_family_known_here_or_not() {
    let target = AccuracyTarget { error: Some(0.3), ..AccuracyTarget::default() };
    let order = order(30.0, &policy(Some(target), Some(family::SAMPLED)));
    assert_eq!((order.family.as_str(), order.fallback), (family::SAMPLED, None));
    assert_eq!(order.reasons[0], "the scene's choice");
    let mut refinement = order.refinement;
    assert_eq!(refinement.climb(), None, "there is nothing to plan");
    let order = self::order(30.0, &policy(Some(target), Some("mine")));
    assert_eq!((order.family.as_str(), order.fallback), ("mine", Some(family::SAMPLED)));
    assert_eq!(order.reasons[0], "the scene's choice");
}

#[test]
fn a_plate_that_is_hit_on_its_face_is_a_shell() {
    let of = |size: Vec3, family: Option<&str>, weak_plane: bool| {
        let (world, plate, hits) = struck_body(size, 30.0);
        let policy = Policy { weak_plane, ..policy(None, family) };
        match decide(&world, plate, &hits, &policy) {
            Some(Decision::Solve(order)) => *order,
            other => panic!("{other:?}"),
        }
    };
    let pane = Vec3::new(0.1, 0.1, 0.006);
    let order = of(pane, None, false);
    assert_eq!((order.family.as_str(), order.fallback), (family::SHELL, Some(family::SAMPLED)));
    assert!(order.reasons[0].contains("17 times as wide as it is thick"), "{:?}", order.reasons);
    assert_eq!(order.choice(), None);
    assert_eq!(of(pane, Some(family::DEFAULT), false).family, family::DEFAULT);
    assert_eq!(of(pane, None, true).family, family::DEFAULT, "its strength has a direction");
    assert_eq!(of(Vec3::new(0.1, 0.1, 0.02), None, false).family, family::DEFAULT, "thick");
    assert_eq!(of(Vec3::new(0.1, 0.008, 0.1), None, false).family, family::DEFAULT, "on its edge");
}

/// A blow too slow to stress a sheet as far as it bears is no job: one on a sheet that is held may
/// press on until all of its energy has bent that.
#[test]
fn a_sheet_is_left_whole_by_what_is_too_slow() {
    let asked = |speed: f64, held: bool| {
        let mut world = World::new(weightless()).unwrap();
        if held {
            put(&mut world, floor());
        }
        let pane = Vec3::new(0.3, 0.3, 0.006);
        let up = if held { 0.5 * pane.z } else { 1.0 };
        let pane = put(&mut world, body("pane", cuboid(pane), GLASS, Vec3::z() * up));
        let ball = body("ball", sphere(0.05, 8), STEEL, Vec3::new(0.01, 0.0, up + 0.06));
        put(&mut world, BodySpec { velocity: -Vec3::z() * speed, breakable: false, ..ball });
        let hits = until_hit(&mut world, 480).into_iter().filter(|hit| hit.body == pane);
        let hits: Vec<Hit> = hits.collect();
        decide(&world, pane, &hits, &policy(None, None)).expect("a body")
    };
    let Decision::Keep(reasons) = asked(0.18, false) else { panic!("solved") };
    let said = reasons[0].to_string();
    assert!(said.contains("below 0.5 of the strength"), "{said}");
    let Decision::Solve(order) = asked(0.18, true) else { panic!("kept") };
    assert_eq!(order.family, family::SHELL);
    assert!(matches!(asked(2.0, false), Decision::Solve(_)));
}

#[test]
fn a_curved_wall_that_is_hit_on_its_face_is_a_shell() {
    let arc = |k: i32| {
        let angle = f64::from(k) * 0.1;
        [0.08 * libm::sin(angle), 0.08 - 0.08 * libm::cos(angle)]
    };
    let profile: Vec<[f64; 2]> = (0..=15).map(arc).collect();
    let of = |thickness: f64, place: Vec3, speed: f64| {
        let mut world = World::new(weightless()).unwrap();
        put(&mut world, floor());
        let detail = Detail { segments: 48, edge: None };
        let mut bowl = lathe_midline(&profile, thickness, detail).unwrap();
        let middle = bowl.mass_properties().centroid;
        bowl.vertices.iter_mut().for_each(|x| *x -= middle);
        let hull = bowl.vertices.clone();
        // Its hollow opens downward.
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
        let mut spec = body("bowl", (Solid::outer(bowl), vec![hull]), GLASS, Vec3::z() * 0.12);
        spec.pose.rotation = turn;
        let bowl = put(&mut world, spec);
        let ball = body("ball", sphere(0.02, 8), STEEL, place);
        put(&mut world, BodySpec { velocity: -Vec3::z() * speed, breakable: false, ..ball });
        let all = until_hit(&mut world, 240);
        let hits: Vec<Hit> = all.into_iter().filter(|hit| hit.body == bowl).collect();
        match decide(&world, bowl, &hits, &policy(None, None)) {
            Some(Decision::Solve(order)) => (order.family, order.reasons),
            other => panic!("{other:?}"),
        }
    };
    let top = Vec3::new(0.004, 0.0, 0.3);
    let (family, reasons) = of(0.004, top, 30.0);
    assert_eq!(family, family::SHELL);
    assert!(reasons[0].contains("times as wide as it is thick"), "{reasons:?}");
    assert_eq!(of(0.03, top, 30.0).0, family::DEFAULT, "thick");
    assert_eq!(of(0.004, top, 60.0).0, family::DEFAULT, "a shell only punches");
}
