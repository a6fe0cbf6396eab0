//! Pieces at rest that become rigid bodies.

use super::super::SoftSolidState;
use super::*;
use cullet_continuum::pieces::GONE;
use cullet_continuum::pieces::patience;
use cullet_model::BodyCut;

/// A block of 0.12 × 0.06 × 0.06 m that is cut in two at x = 0.018, both parts at rest.
struct CutBlock {
    prepared: Arc<PreparedSoftSolid>,
    state: SoftSolidState,
    /// The part of 0.042 m.
    less: u32,
}

impl CutBlock {
    fn new() -> Self {
        let bonds = BondedSolid { breaks: true, ..elastic() };
        let mut setup = block([0.12, 0.06, 0.06], 0.012, bonds);
        let corner = |y: f64, z: f64| Vec3::new(0.018, y, z);
        let corners =
            vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        body(&mut setup).cuts = vec![BodyCut { corners }];
        let prepared = prepared(&setup);
        let bytes = solved(&prepared, None, window(0, 1, vec![])).unwrap().state;
        let mut state = SoftSolidState::decode(&prepared, &bytes).unwrap();
        state.pieces.iter_mut().for_each(|piece| piece.still = patience(WORLD_STEP));
        let last = (0..state.labels.len())
            .max_by(|&p, &q| state.domain.places[p].x.total_cmp(&state.domain.places[q].x));
        let less = state.labels[last.unwrap()];
        Self { prepared, state, less }
    }

    fn solve(&self, state: &SoftSolidState, window: Window) -> WindowOutcome {
        solved(&self.prepared, Some(&state.encode(&self.prepared)), window).unwrap()
    }

    fn decode(&self, outcome: &WindowOutcome) -> SoftSolidState {
        SoftSolidState::decode(&self.prepared, &outcome.state).unwrap()
    }

    /// Its state with one of the parts on its way to the other, at 0.5 m/s.
    fn moving(&self, number: u32) -> SoftSolidState {
        let mut state = self.state.clone();
        let speed = if number == self.less { -0.5 } else { 0.5 };
        let rows = state.domain.velocities.iter_mut().zip(&state.labels);
        rows.filter(|(_, label)| **label == number).for_each(|(v, _)| v.x = speed);
        let mut own = state.pieces.iter_mut().filter(|piece| piece.number == number);
        own.next().unwrap().still = 0;
        state
    }
}

fn retiring(first: u64, steps: u32, retired: Option<Vec<u32>>) -> Window {
    Window { retired, ..window(first, steps, vec![]) }
}

/// Places and velocities of a piece's points.
fn motion(state: &SoftSolidState, number: u32) -> Vec<(Vec3, Vec3)> {
    let rows = state.domain.places.iter().zip(&state.domain.velocities).zip(&state.labels);
    rows.filter(|(_, label)| **label == number).map(|((x, v), _)| (*x, *v)).collect()
}

#[test]
fn parts_at_rest_are_offered_with_their_volume() {
    let cut = CutBlock::new();
    let offered = cut.solve(&cut.state, retiring(1, 1, Some(vec![])));
    assert_eq!(offered.settled.len(), 2, "{:?}", offered.pieces);
    for (piece, torn) in offered.settled.iter().zip(&offered.pieces) {
        let (length, middle) = match piece.number == cut.less {
            true => (0.042, 0.039),
            false => (0.078, -0.021),
        };
        assert_eq!(piece.number, torn.number);
        assert!((piece.mass / torn.mass - 1.0).abs() < 1e-9 && piece.solid.mesh.is_closed());
        let volume = piece.solid.mesh.mass_properties().volume / (0.0036 * length);
        assert!((volume - 1.0).abs() < 0.05, "{volume}");
        assert!((piece.mass / (3.6 * length) - 1.0).abs() < 0.05, "{}", piece.mass);
        assert!((piece.place - Vec3::new(middle, 0.0, 0.0)).norm() < 1e-3, "{}", piece.place);
    }
    let mass: f64 = offered.settled.iter().map(|piece| piece.mass).sum();
    assert!((mass / offered.ledger.mass - 1.0).abs() < 1e-9);
    assert!(cut.solve(&cut.state, retiring(1, 1, None)).settled.is_empty());
    let moving = cut.solve(&cut.moving(cut.less), retiring(1, 1, Some(vec![])));
    assert!(moving.settled.iter().all(|piece| piece.number != cut.less), "{:?}", moving.pieces);
}

/// What is gone is as if it were far away: the other part goes through where it was.
#[test]
fn a_part_that_is_gone_is_nowhere() {
    let cut = CutBlock::new();
    let (gone, stays) = (cut.less, 1 - cut.less);
    let state = cut.moving(stays);
    let without = cut.solve(&state, retiring(1, 8, Some(vec![gone])));
    let beside = cut.solve(&state, retiring(1, 8, None));
    let mut apart = state.clone();
    for (x, _) in apart.domain.places.iter_mut().zip(&state.labels).filter(|(_, n)| **n == gone) {
        x.z += 10.0;
    }
    let apart = cut.solve(&apart, retiring(1, 8, None));
    let end = cut.decode(&without);
    assert!(motion(&end, stays) == motion(&cut.decode(&apart), stays));
    assert!(motion(&end, stays) != motion(&cut.decode(&beside), stays), "they never met");
    assert!(motion(&end, gone) == motion(&state, gone), "it lies where it lay");
    assert!(end.encode(&cut.prepared) == without.state);
    assert!(end.pieces.iter().any(|piece| piece.number == gone && piece.still == GONE));
    let own: Vec<u32> = without.pieces.iter().map(|piece| piece.number).collect();
    assert_eq!(own, [stays]);
    assert!((without.ledger.mass / without.pieces[0].mass - 1.0).abs() < 1e-12);
    assert!((without.ledger.momentum[0] / (0.5 * without.ledger.mass) - 1.0).abs() < 1e-9);
    assert!(without.ledger.residual.abs() < 1e-9 * without.ledger.kinetic);
    let right = 0.018 + 0.5 * 8.0 * WORLD_STEP;
    assert!((without.extent.high[0] - right).abs() < 0.012, "{:?}", without.extent);
    let volume = |outcome: &WindowOutcome| {
        let (surface, frame) = (&outcome.surfaces[0], &outcome.frames[0]);
        let vertices = frame.offsets.iter().map(|x| Vec3::from(x.map(f64::from))).collect();
        let triangles = surface.triangles.clone();
        cullet_geometry::TriMesh { vertices, triangles }.signed_volume()
    };
    let drawn = volume(&without) / volume(&beside);
    assert!((drawn / 0.65 - 1.0).abs() < 0.05, "{drawn}");
    // Windows may be cut anywhere.
    let first = cut.solve(&state, retiring(1, 3, Some(vec![gone])));
    let window = retiring(4, 5, Some(vec![]));
    let second = solved(&cut.prepared, Some(&first.state), window).unwrap();
    assert!(second.state == without.state && second.settled.is_empty());
    assert_eq!(second.pieces, without.pieces);
}

#[test]
fn nothing_is_left_where_all_parts_are_gone_and_only_what_rests_can_go() {
    let cut = CutBlock::new();
    let gone = cut.solve(&cut.state, retiring(1, 3, Some(vec![0, 1])));
    assert!(gone.pieces.is_empty() && gone.settled.is_empty());
    assert_eq!((gone.ledger.mass, gone.ledger.stretching, gone.ledger.residual), (0.0, 0.0, 0.0));
    assert!(gone.surfaces.iter().all(|surface| surface.triangles.is_empty()));
    assert!(gone.extent.high[0] > 0.05 && gone.figures.iter().all(|all| all.value.is_finite()));
    let refused = |number: u32| {
        let bytes = cut.moving(0).encode(&cut.prepared);
        let window = retiring(1, 1, Some(vec![number]));
        let run = SoftSolidWindow::open(Arc::clone(&cut.prepared), Some(&bytes), window);
        run.err().map(|refusal| refusal.to_string()).unwrap_or_default()
    };
    assert!(refused(0).contains("piece 0") && refused(7).contains("piece 7"));
    assert_eq!(refused(1), "");
}
