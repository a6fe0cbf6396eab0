use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::tests::{setup, solve, window, with};
use cullet_continuum::pieces::GONE;
use cullet_geometry::{Pose, Vec3};
use cullet_model::{Continuum, Proxy, ProxyMotion, Window, WindowOutcome};
use std::sync::{Arc, LazyLock};

/// Thickness, and contact of a point with a floor at z = 0 \[m\].
const THICKNESS: f64 = 3e-3;
const CONTACT: f64 = 1.5e-3;

fn floor() -> Proxy {
    let corner = |k: u32| Vec3::from([0, 1, 2].map(|axis| f64::from(k >> axis & 1) - 0.5));
    let part = (0..8).map(|k| corner(k).component_mul(&Vec3::new(1.0, 1.0, 0.2))).collect();
    Proxy {
        body: 1,
        object: None,
        parts: vec![part],
        friction: 0.3,
        pose: Pose::translation(0.1, 0.05, -0.1),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        motion: ProxyMotion::Steady,
    }
}

fn on_floor(first: u64, steps: u32, retired: Option<Vec<u32>>) -> Window {
    Window { proxies: vec![floor()], retired, ..window(first, steps) }
}

/// A sheet that is cut into two of 0.12 and 0.08 m, and both after 200 steps on a floor.
struct TwoOnFloor {
    prepared: Arc<PreparedMembrane>,
    outcome: WindowOutcome,
}

static TWO: LazyLock<TwoOnFloor> = LazyLock::new(|| {
    let mut setup = with(setup(), |sheet| {
        sheet.pose = Pose::translation(0.0, 0.0, CONTACT + 1e-4);
        sheet.material.damping = 0.5;
        sheet.spacing = 0.01;
        sheet.thickness = THICKNESS;
        sheet.notches = vec![vec![[0.12, -0.01], [0.12, 0.11]]];
    });
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    let prepared = Arc::new(PreparedMembrane::new(&setup).unwrap());
    let outcome = *solve(&prepared, None, on_floor(0, 200, Some(vec![])));
    TwoOnFloor { prepared, outcome }
});

impl TwoOnFloor {
    fn state(&self) -> SheetState {
        SheetState::decode(&self.prepared, &self.outcome.state).unwrap()
    }

    fn solve(&self, state: &SheetState, window: Window) -> Box<WindowOutcome> {
        solve(&self.prepared, Some(&state.encode(&self.prepared)), window)
    }
}

/// Slides a piece at 1 m/s along x, awake.
fn slide(state: &mut SheetState, number: u32) {
    for (v, _) in state.velocities.iter_mut().zip(&state.labels).filter(|(_, l)| **l == number) {
        *v = Vec3::new(1.0, 0.0, 0.0);
    }
    state.pieces.iter_mut().filter(|piece| piece.number == number).for_each(|p| p.still = 0);
}

/// Places and velocities of a piece's points.
fn motion(state: &SheetState, number: u32) -> Vec<(Vec3, Vec3)> {
    let rows = state.places.iter().zip(&state.velocities).zip(&state.labels);
    rows.filter(|(_, label)| **label == number).map(|((x, v), _)| (*x, *v)).collect()
}

#[test]
fn pieces_at_rest_are_offered_as_plates() {
    let two = &*TWO;
    let settled = &two.outcome.settled;
    assert_eq!(settled.iter().map(|piece| piece.number).collect::<Vec<_>>(), [0, 1]);
    let areas = [0.1 * 0.12, 0.1 * 0.08];
    for (piece, (torn, area)) in settled.iter().zip(two.outcome.pieces.iter().zip(areas)) {
        let mesh = &piece.solid.mesh;
        assert!((piece.mass / torn.mass - 1.0).abs() < 1e-9 && mesh.is_closed());
        let properties = mesh.mass_properties();
        let volume = properties.volume / (THICKNESS * area);
        assert!((volume - 1.0).abs() < 0.05, "{volume}");
        assert!(properties.centroid.norm() < 1e-12);
        // It lies where the piece lay, on the floor.
        let low = mesh.vertices.iter().map(|v| v.z + piece.place.z).fold(f64::MAX, f64::min);
        assert!(low.abs() < 0.1 * THICKNESS, "{low}");
    }
    let mass: f64 = settled.iter().map(|piece| piece.mass).sum();
    assert!((mass / (1000.0 * THICKNESS * 0.02) - 1.0).abs() < 1e-9, "{mass}");
    assert!((settled[0].place.x - 0.06).abs() < 2e-3, "{}", settled[0].place);
    // Once more while nobody takes them; never where none is wanted, and none that moves.
    let again = two.solve(&two.state(), on_floor(200, 1, Some(vec![])));
    assert_eq!(again.settled, *settled);
    assert!(two.solve(&two.state(), on_floor(200, 1, None)).settled.is_empty());
    let mut moving = two.state();
    slide(&mut moving, 0);
    let moving = two.solve(&moving, on_floor(200, 1, Some(vec![])));
    assert!(moving.settled.iter().all(|piece| piece.number != 0), "{:?}", moving.pieces);
}

/// What is gone is as if it were far away: the other piece slides through where it was.
#[test]
fn a_piece_that_is_gone_is_nowhere() {
    let two = &*TWO;
    let mut state = two.state();
    slide(&mut state, 0);
    let shown = |retired| Window { frame_every: 4, ..on_floor(200, 8, retired) };
    let gone = two.solve(&state, shown(Some(vec![1])));
    let beside = two.solve(&state, shown(None));
    let mut apart = state.clone();
    for (x, _) in apart.places.iter_mut().zip(&state.labels).filter(|(_, label)| **label == 1) {
        x.z += 10.0;
    }
    let apart = two.solve(&apart, shown(None));
    let decoded =
        |outcome: &WindowOutcome| SheetState::decode(&two.prepared, &outcome.state).unwrap();
    assert!(motion(&decoded(&gone), 0) == motion(&decoded(&apart), 0));
    assert!(motion(&decoded(&gone), 0) != motion(&decoded(&beside), 0), "they never met");
    assert!(motion(&decoded(&gone), 1) == motion(&state, 1), "it lies where it lay");
    assert!(decoded(&gone).encode(&two.prepared) == gone.state);
    assert_eq!(decoded(&gone).pieces[1].still, GONE);
    // It is in no list and no sum, and none of it is drawn.
    let own = &two.outcome.pieces[0];
    assert_eq!(gone.pieces.iter().map(|piece| piece.number).collect::<Vec<_>>(), [0]);
    assert!((gone.ledger.mass / own.mass - 1.0).abs() < 1e-12);
    assert!(gone.ledger.stretching < beside.ledger.stretching);
    assert!(gone.ledger.residual.abs() < 0.02 * gone.ledger.kinetic, "{:?}", gone.ledger);
    assert!(gone.extent.high[0] < 0.17 && beside.extent.high[0] > 0.19, "{:?}", gone.extent);
    let [drawn, whole] = [&gone, &beside].map(|outcome| {
        let (surface, frame) = (&outcome.surfaces[0], &outcome.frames[0]);
        assert_eq!(surface.reference.len(), frame.offsets.len());
        let place = |v: u32| Vec3::from(frame.offsets[v as usize].map(f64::from));
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(place);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        surface.triangles.iter().map(area).sum::<f64>()
    });
    assert!((drawn / whole - 0.6).abs() < 0.01, "{drawn} of {whole}");
}

#[test]
fn windows_after_one_is_gone_may_be_cut_anywhere() {
    let two = &*TWO;
    let mut state = two.state();
    slide(&mut state, 1);
    let whole = two.solve(&state, on_floor(200, 8, Some(vec![0])));
    let first = two.solve(&state, on_floor(200, 3, Some(vec![0])));
    let second = solve(&two.prepared, Some(&first.state), on_floor(203, 5, Some(vec![])));
    assert!(second.state == whole.state);
    assert_eq!(second.pieces, whole.pieces);
    assert_eq!(second.settled, []);
}

/// Nothing is left: bodies go their way, and numbers stay numbers.
#[test]
fn a_window_of_nothing_moves_bodies_alone() {
    let two = &*TWO;
    let ball = Proxy {
        body: 7,
        object: None,
        pose: Pose::translation(0.05, 0.05, 0.3),
        motion: ProxyMotion::Free { mass: 0.02, inertia: cullet_geometry::Mat3::identity() * 2e-6 },
        ..floor()
    };
    let mut empty = on_floor(200, 4, Some(vec![0, 1]));
    empty.proxies.push(ball);
    empty.frame_every = 2;
    let gone = two.solve(&two.state(), empty);
    assert!(gone.pieces.is_empty() && gone.settled.is_empty());
    assert_eq!((gone.ledger.mass, gone.ledger.residual), (0.0, 0.0));
    assert!(gone.surfaces.iter().all(|surface| surface.triangles.is_empty()));
    assert!(gone.extent.high[0] > 0.19 && gone.extent.low[2].is_finite(), "{:?}", gone.extent);
    assert!(gone.figures.iter().all(|figure| figure.value.is_finite()), "{:?}", gone.figures);
    let fallen = 0.3 - gone.handed[1].poses[3].translation.z;
    let time = 4.0 / 240.0;
    assert!((fallen / (0.5 * 9.81 * time * time) - 1.0).abs() < 1e-3, "{fallen}");
    assert!(gone.handed.iter().all(|all| all.impulses.iter().flatten().all(|j| j.norm() == 0.0)));
}

#[test]
fn only_pieces_at_rest_can_be_retired() {
    let two = &*TWO;
    let refused = |state: &SheetState, number: u32| {
        let window = on_floor(200, 1, Some(vec![number]));
        let bytes = state.encode(&two.prepared);
        let run = crate::MembraneWindow::open(Arc::clone(&two.prepared), Some(&bytes), window);
        run.err().map(|refusal| refusal.to_string()).unwrap_or_default()
    };
    let mut state = two.state();
    slide(&mut state, 0);
    assert!(refused(&state, 0).contains("piece 0"));
    assert!(refused(&state, 5).contains("piece 5"));
    assert_eq!(refused(&state, 1), "");
}
