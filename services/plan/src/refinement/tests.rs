use super::{Experience, HitClass, Next, Refinement};
use crate::brittle::{AccuracyTarget, Regime, SolvePlan, SpacingBound};
use cullet_model::outcome::{FOUND_FRAGMENTS, FOUND_LARGEST};
use cullet_model::{Fragment, Fragmentation, Report};

fn plan(coarsest: f64) -> SolvePlan {
    SolvePlan {
        regime: Regime::Dynamic,
        ratio: 1.0,
        duration: 1e-4,
        rate: 1e3,
        size: 5e-3,
        count: 100.0,
        spacing: 1e-3,
        coarsest,
        bound: SpacingBound::Error,
        finest: (1e-3, SpacingBound::Points),
        points: 1e4,
        steps: 500.0,
        cost: 1.0,
        error: 0.1,
        softening: 1e-4,
    }
}

fn brick() -> HitClass {
    HitClass::new("brick", 2e-3, 4.0, 14.0)
}

fn ladder(coarsest: f64, error: Option<f64>) -> Refinement {
    Refinement::new(
        &plan(coarsest),
        &AccuracyTarget { error, ..AccuracyTarget::default() },
        brick(),
    )
}

#[test]
fn coarser_solves_come_first_where_the_body_has_room_for_them() {
    let all = |mut ladder: Refinement| {
        let mut spacings = Vec::new();
        while let Some(h) = ladder.climb() {
            spacings.push(h);
        }
        spacings
    };
    assert_eq!(all(ladder(8e-3, Some(0.1))), [8e-3, 4e-3, 2e-3, 1e-3]);
    assert_eq!(all(ladder(5e-3, Some(0.1))), [5e-3, 2.5e-3, 1e-3]);
    assert_eq!(all(ladder(2.9e-3, Some(0.1))), [1e-3]);
    assert_eq!(all(ladder(1.0, None)), [1e-3]);
    assert!(all(Refinement::default()).is_empty());
}

#[test]
fn a_solve_that_failed_is_followed_by_a_finer_one_and_the_last_is_final() {
    let (mut ladder, mut seen) = (ladder(5e-3, Some(0.1)), Experience::default());
    ladder.climb();
    let next = ladder.next(None, &mut seen);
    assert!(matches!(next, Next::Finer(why) if why.contains("did not come to an end")));
    ladder.climb();
    assert!(matches!(ladder.next(None, &mut seen), Next::Finer(_)));
    ladder.climb();
    assert_eq!(ladder.next(None, &mut seen), Next::Use(None));
}

/// A body that stays whole at that spacing.
fn whole(spacing: f64) -> Fragmentation {
    let corner = |p: [f64; 3]| cullet_geometry::Vec3::from(p);
    let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(corner);
    let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let mesh = cullet_geometry::TriMesh { vertices: vertices.to_vec(), triangles };
    let solid = cullet_geometry::Solid::outer(mesh);
    let (still, sheet) = (cullet_geometry::Vec3::zeros(), cullet_geometry::Sheet::default());
    let (velocity, spin) = (still, still);
    let fragment = Fragment { solid, hulls: Vec::new(), velocity, spin, sheet };
    let report = Report { spacing, ..Default::default() };
    Fragmentation { fragments: vec![fragment], report, ..Default::default() }
}

/// F23: half again as many pieces on the finer grid.
#[test]
fn pieces_that_come_with_the_grid_are_told() {
    let mut ladder = ladder(5e-3, Some(0.1));
    let mut seen = Experience::default();
    let mut fine = whole(1.25e-3);
    fine.fragments.push(fine.fragments[0].clone());
    ladder.next(Some(&whole(5e-3)), &mut seen);
    ladder.climb();
    let Next::Finer(why) = ladder.next(Some(&fine), &mut seen) else { panic!("not finer") };
    assert!(why.ends_with("; 1 pieces, then 2: their number is the grid's (F23)"), "{why}");
    assert_eq!(super::told(10, 14), "");
}

/// Two grids that found 2 and 3 pieces, of which the scene makes as many as it wants.
#[test]
fn grids_are_compared_by_what_they_found() {
    let pieces = |spacing: f64, found: usize| {
        let mut outcome = whole(spacing);
        let one = outcome.fragments[0].clone();
        outcome.fragments.resize(found, one);
        outcome
    };
    let directed = |spacing: f64, found: usize| {
        let mut outcome = pieces(spacing, 24);
        let share = 1.0 / found as f64;
        outcome.report =
            outcome.report.with(FOUND_FRAGMENTS, "1", found as f64).with(FOUND_LARGEST, "1", share);
        outcome
    };
    let told = |make: &dyn Fn(f64, usize) -> Fragmentation| {
        let (mut ladder, mut seen) = (ladder(5e-3, Some(0.01)), Experience::default());
        ladder.climb();
        ladder.next(Some(&make(5e-3, 2)), &mut seen);
        ladder.climb();
        ladder.next(Some(&make(2.5e-3, 3)), &mut seen)
    };
    let plain = told(&pieces);
    assert!(matches!(&plain, Next::Finer(why) if why.contains("over 0.01")), "{plain:?}");
    assert_eq!(told(&directed), plain);
}

/// Three hits that stay whole on two grids: the fourth, if like them, needs but one.
#[test]
fn a_hit_like_others_is_taken_at_its_word() {
    let mut seen = Experience::default();
    let climbs = |speed: f64, seen: &mut Experience| {
        let kind = HitClass::new("brick", 2e-3, speed, 14.0);
        let need = AccuracyTarget { error: Some(0.1), ..AccuracyTarget::default() };
        let mut ladder = Refinement::new(&plan(5e-3), &need, kind);
        let mut told = Vec::new();
        while let Some(h) = ladder.climb() {
            let next = ladder.next(Some(&whole(h)), seen);
            told.push(next.clone());
            if matches!(next, Next::Use(_)) {
                break;
            }
        }
        told
    };
    for _ in 0..3 {
        assert_eq!(climbs(4.5, &mut seen).len(), 2);
    }
    let told = climbs(5.5, &mut seen);
    let wanted = "3 hits like it had errors up to 0.00 on this grid, within 0.1";
    assert_eq!(told, [Next::Use(Some(wanted.to_owned()))]);
    // Twice as fast is another thing.
    assert_eq!(climbs(9.0, &mut seen).len(), 2);
}

/// Solves of 5 and 2.5 mm, of the plan's 1 mm for 1 s, and finer ones, of a crack whose area is off
/// by a fifth a millimetre: the spacings \[m\], and all that is said from the plan's on.
fn climbed(finest: (f64, SpacingBound), budget: Option<f64>) -> (Vec<f64>, Vec<String>) {
    let plan = SolvePlan { finest, ..plan(5e-3) };
    let mut ladder = Refinement::new(
        &plan,
        &AccuracyTarget { error: Some(0.1), budget, ..AccuracyTarget::default() },
        brick(),
    );
    let (mut spacings, mut said, mut seen) = (Vec::new(), Vec::new(), Experience::default());
    while let Some(h) = ladder.climb() {
        spacings.push(h);
        let mut outcome = whole(h);
        outcome.report.crack_area = 1.0 + 200.0 * h;
        let next = ladder.next(Some(&outcome), &mut seen);
        if let Next::Finer(why) | Next::Use(Some(why)) = &next {
            said.extend((h < 1.1e-3).then(|| why.clone()));
        }
        if matches!(next, Next::Use(_)) {
            break;
        }
    }
    (spacings, said)
}

/// Halves until the error is within the one asked for, and says what it is about to spend.
#[test]
fn a_plan_that_proves_too_coarse_is_gone_beyond() {
    let (spacings, said) = climbed((1e-4, SpacingBound::Points), None);
    assert_eq!(spacings, [5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4]);
    assert_eq!(
        said,
        [
            "its error is about 0.21, over 0.1; finer than planned: 5.000e-4 m, 16.00 s",
            "its error is about 0.11, over 0.1; finer than planned: 2.500e-4 m, 256.00 s",
            "this is finer than the plan; its error is about 0.06, within 0.1",
        ]
    );
}

/// What bounds the finest solve is reported, and reached where that is worth its while.
#[test]
fn nothing_is_finer_than_points_and_generation_allow() {
    let (spacings, said) = climbed((8e-4, SpacingBound::Points), None);
    assert_eq!(spacings, [5e-3, 2.5e-3, 1e-3]);
    let wanted = "this is the plan's grid; its error is about 0.21, over 0.1; \
                  none below 8.000e-4 m by the most points";
    assert_eq!(said, [wanted]);
    let (spacings, said) = climbed((6e-4, SpacingBound::Parent), None);
    assert_eq!(spacings, [5e-3, 2.5e-3, 1e-3, 6e-4]);
    let wanted = "this is finer than the plan; its error is about 0.13, over 0.1; \
                  none below 6.000e-4 m by the solve that made it";
    assert_eq!(said[1..], [wanted]);
    let (spacings, said) = climbed((1e-3, SpacingBound::Generation), Some(1e6));
    assert_eq!(spacings.len(), 3);
    assert!(said[0].ends_with("; none below 1.000e-3 m by its generation"), "{said:?}");
}

/// All solves of a hit are paid from one budget, by what they were reckoned to cost.
#[test]
fn a_budget_pays_for_all_solves_of_a_hit() {
    let of = |budget: f64| climbed((1e-4, SpacingBound::Points), Some(budget));
    let (spacings, said) = of(20.0);
    assert_eq!(spacings, [5e-3, 2.5e-3, 1e-3, 5e-4]);
    assert!(said[1].ends_with("; 2.97 s of the budget's 20.00 s are left"), "{said:?}");
    // Not a half, but as fine as the rest of it pays for.
    let (spacings, _) = of(10.0);
    assert!(spacings.len() == 4 && spacings[3] > 5e-4, "{spacings:?}");
    let spent: f64 = spacings.iter().map(|h| (1e-3 / h).powi(4)).sum();
    assert!((spent - 10.0).abs() < 1e-9, "{spent}");
    for (budget, left) in
        [(5.0, "3.97 s of the budget's 5.00 s"), (1.0, "0.00 s of the budget's 1")]
    {
        let (spacings, said) = of(budget);
        assert_eq!(spacings.len(), 3);
        assert!(said[0].starts_with("this is the plan's grid; its error is about 0.21, over"));
        assert!(said[0].contains(left), "{said:?}");
    }
}

/// What another family made has no grid: it is compared with nothing, and nothing is learnt of it.
#[test]
fn pieces_without_a_grid_are_no_estimate() {
    let (mut ladder, mut seen) = (ladder(5e-3, Some(0.1)), Experience::default());
    for h in [5e-3, 2.5e-3] {
        ladder.climb();
        let mut outcome = whole(h);
        outcome.report.crack_area = h;
        assert!(matches!(ladder.next(Some(&outcome), &mut seen), Next::Finer(_)));
    }
    ladder.climb();
    let before = format!("{seen:?}");
    assert_eq!(ladder.next(Some(&whole(0.0)), &mut seen), Next::Use(None));
    assert_eq!(format!("{seen:?}"), before);
}
