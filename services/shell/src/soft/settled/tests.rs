use crate::soft::SoftShellWindow;
use crate::soft::prepared::{PreparedFunctions, PreparedSoftShell, PreparedWall};
use crate::soft::state::SoftShellState;
use cullet_continuum::pieces::{GONE, patience};
use cullet_geometry::shapes::{Detail, cuboid};
use cullet_geometry::{Mat3, Pose, Solid, Vec3};
use cullet_model::{
    BodyCut, Continuum, ContinuumBody, ContinuumSetup, Material, MembranePace, Proxy, ProxyMotion,
    SheetAir, SoftBody, SoftLaw, Window, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

const WORLD_STEP: f64 = 1.0 / 240.0;
const SIZE: [f64; 3] = [0.2, 0.1, 4e-3];
const RUBBER: Material = Material {
    density: 1000.0,
    young: 3.2e5,
    poisson: 0.3,
    failure_stress: 8e4,
    fracture_energy: 300.0,
};

/// A sheet that is cut across x from its lower side up to some y.
struct CutSheet {
    prepared: Arc<PreparedSoftShell>,
    /// After a step, all of it at rest.
    state: SoftShellState<9>,
}

fn retiring(first_step: u64, steps: u32, retired: Option<Vec<u32>>) -> Window {
    Window { first_step, steps, frame_every: 4, proxies: vec![], retired }
}

impl CutSheet {
    fn new(x: f64, y: f64) -> Self {
        let mesh = cuboid(Vec3::from(SIZE), Detail::default()).unwrap();
        let corner = |y: f64, z: f64| Vec3::new(x, y, z);
        let corners = vec![corner(-1.0, -1.0), corner(y, -1.0), corner(y, 1.0), corner(-1.0, 1.0)];
        let air = SheetAir {
            density: 0.0,
            drag: 0.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        };
        let body = SoftBody {
            solid: Arc::new(Solid::outer(mesh)),
            material: RUBBER,
            law: SoftLaw::Shell { hardening: None, breaks: true },
            spacing: 0.02,
            damping: 0.0,
            pose: Pose::identity(),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            grips: vec![],
            cuts: vec![BodyCut { corners }],
            air,
            pace: MembranePace::Real,
        };
        let (body, gravity) = (ContinuumBody::Soft(body), Vec3::zeros());
        let setup = ContinuumSetup { body, world_step: WORLD_STEP, gravity, seed: 1 };
        let prepared = Arc::new(SoftShellWindow::prepare(&setup).unwrap());
        let first = solved(&prepared, None, retiring(0, 1, None));
        let mut state = SoftShellState::decode(wall(&prepared), &first.state).unwrap();
        state.pieces.iter_mut().for_each(|piece| piece.still = patience(WORLD_STEP));
        state.domain.velocity.fill(Vec3::zeros());
        Self { prepared, state }
    }

    /// In two parts, of 0.12 and 0.08 m.
    fn two() -> Self {
        let cut = Self::new(0.02, 1.0);
        assert_eq!(cut.state.pieces.len(), 2);
        cut
    }

    fn solve(&self, state: &SoftShellState<9>, window: Window) -> WindowOutcome {
        solved(&self.prepared, Some(&state.encode(wall(&self.prepared))), window)
    }

    fn decode(&self, outcome: &WindowOutcome) -> SoftShellState<9> {
        SoftShellState::decode(wall(&self.prepared), &outcome.state).unwrap()
    }

    /// Its state with one of the parts on its way to the other, at 0.5 m/s.
    fn moving(&self, number: u32) -> SoftShellState<9> {
        let mut state = self.state.clone();
        let speed = if number == 0 { 0.5 } else { -0.5 };
        nodes(&state, number).into_iter().for_each(|n| state.domain.velocity[n].x = speed);
        state.pieces.iter_mut().filter(|p| p.number == number).for_each(|p| p.still = 0);
        state
    }
}

fn wall(prepared: &PreparedSoftShell) -> &Arc<PreparedWall<9>> {
    let PreparedFunctions::Nine(wall) = &prepared.0 else { panic!("a rectangle has nine") };
    wall
}

fn solved(
    prepared: &Arc<PreparedSoftShell>,
    state: Option<&[u8]>,
    window: Window,
) -> WindowOutcome {
    let mut run = SoftShellWindow::open(Arc::clone(prepared), state, window).unwrap();
    loop {
        match run.advance() {
            WindowProgress::Running(_) => {}
            WindowProgress::Done(outcome) => return *outcome,
            WindowProgress::Failed(failure) => panic!("{failure:?}"),
        }
    }
}

/// Control points of a piece, rising.
fn nodes(state: &SoftShellState<9>, number: u32) -> Vec<usize> {
    let domain = &state.domain;
    let own = domain.live().filter(|&p| state.labels[p] == number);
    let mut nodes: Vec<usize> =
        own.flat_map(|p| domain.functions(p).0.map(|n| n as usize)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Places and velocities of a piece's control points.
fn motion(state: &SoftShellState<9>, number: u32) -> Vec<([f64; 4], Vec3)> {
    let of = |n: usize| (state.domain.displacement[n], state.domain.velocity[n]);
    nodes(state, number).into_iter().map(of).collect()
}

fn figure(outcome: &WindowOutcome, name: &str) -> Option<f64> {
    outcome.figures.iter().find(|figure| figure.name == name).map(|figure| figure.value)
}

#[test]
fn parts_at_rest_are_offered_as_closed_walls() {
    let cut = CutSheet::two();
    let offered = cut.solve(&cut.state, retiring(1, 1, Some(vec![])));
    assert_eq!(offered.settled.iter().map(|piece| piece.number).collect::<Vec<_>>(), [0, 1]);
    for (piece, torn) in offered.settled.iter().zip(&offered.pieces) {
        let (length, middle) = [(0.12, -0.04), (0.08, 0.06)][piece.number as usize];
        let mesh = &piece.solid.mesh;
        assert!(mesh.is_closed() && mesh.components().len() == 1);
        assert!((piece.mass / torn.mass - 1.0).abs() < 1e-12);
        let properties = mesh.mass_properties();
        let volume = properties.volume / (SIZE[1] * SIZE[2] * length);
        assert!((volume - 1.0).abs() < 1e-6, "{volume}");
        assert!(properties.centroid.norm() < 1e-12);
        assert!((piece.place - Vec3::new(middle, 0.0, 0.0)).norm() < 1e-6, "{}", piece.place);
        // Its inertia about z is that of the bar.
        let inertia = properties.inertia[(2, 2)] / properties.volume;
        let wanted = (length * length + SIZE[1] * SIZE[1]) / 12.0;
        assert!((inertia / wanted - 1.0).abs() < 1e-5, "{inertia}");
    }
    let mass: f64 = offered.settled.iter().map(|piece| piece.mass).sum();
    assert!((mass / (1000.0 * SIZE.iter().product::<f64>()) - 1.0).abs() < 1e-9, "{mass}");
    assert_eq!(figure(&offered, "unfit_pieces"), None);
    // Once more while nobody takes them; never where none is wanted, and none that moves.
    let again = cut.solve(&cut.decode(&offered), retiring(2, 1, Some(vec![])));
    assert_eq!(again.settled, offered.settled);
    assert!(cut.solve(&cut.state, retiring(1, 1, None)).settled.is_empty());
    let moving = cut.solve(&cut.moving(1), retiring(1, 1, Some(vec![])));
    assert!(moving.settled.iter().all(|piece| piece.number != 1), "{:?}", moving.pieces);
}

/// Both lips of a slit have walls, and what has bent keeps its shape.
#[test]
fn a_slit_has_two_walls_and_a_bent_sheet_is_bent() {
    let cut = CutSheet::new(0.0, 4e-3);
    assert_eq!(cut.state.pieces.len(), 1);
    let flat = cut.solve(&cut.state, retiring(1, 1, Some(vec![])));
    let mesh = &flat.settled[0].solid.mesh;
    assert!(mesh.is_closed());
    let [a, b, t] = SIZE;
    let around = 2.0 * (a + b) + 2.0 * 0.05;
    let area = mesh.area() / (2.0 * a * b + t * around);
    assert!((area - 1.0).abs() < 1e-4, "{area}");
    // Rolled to three quarters of a tube.
    let mut state = cut.state.clone();
    let radius = a / 4.5;
    place(&mut state, |x| {
        let (s, c) = libm::sincos(x.x / radius);
        Vec3::new(radius * s, x.y, radius * c)
    });
    let bent = cut.solve(&state, retiring(1, 1, Some(vec![])));
    let [piece] = &bent.settled[..] else { panic!("{:?}", bent.figures) };
    let mesh = &piece.solid.mesh;
    assert!(mesh.is_closed());
    // The walls are a thickness apart, and their middle is the tube that control points are around.
    let (front, back) = mesh.vertices.split_at(mesh.vertices.len() / 2);
    for (front, back) in front.iter().zip(back) {
        let apart = (front - back).norm() / t;
        assert!((0.999..1.03).contains(&apart), "{apart}");
        let middle = 0.5 * (front + back) + piece.place;
        let off = (middle.x * middle.x + middle.z * middle.z).sqrt() / radius;
        assert!((0.96..1.001).contains(&off), "{off}");
    }
    let volume = mesh.signed_volume() / (a * b * t);
    assert!((volume - 1.0).abs() < 0.03, "{volume}");
    assert_eq!(bent.settled[0].mass, flat.settled[0].mass);
}

/// Puts control points where `to` takes the places that they began at.
fn place(state: &mut SoftShellState<9>, to: impl Fn(Vec3) -> Vec3) {
    let (first, _) = state.domain.node_places();
    for (u, x) in state.domain.displacement.iter_mut().zip(first) {
        let moved = to(x) - x;
        *u = [moved.x, moved.y, moved.z, 0.0];
    }
}

/// A sheet that goes through itself bounds no solid: it stays soft, and is counted.
#[test]
fn a_sheet_that_crosses_itself_stays_soft_and_is_counted() {
    let cut = CutSheet::new(0.0, -1.0);
    // An eight lying on its side, from one end on: it crosses itself at half a turn.
    let eight = |turn: f64| {
        let mut state = cut.state.clone();
        place(&mut state, |x| {
            let angle = (x.x / SIZE[0] + 0.5) * turn - 0.5;
            Vec3::new(0.1 * libm::sin(angle), x.y, 0.1 * libm::sin(2.0 * angle))
        });
        cut.solve(&state, retiring(1, 1, Some(vec![])))
    };
    let open = eight(3.0);
    assert_eq!((open.settled.len(), figure(&open, "unfit_pieces")), (1, None));
    let crossed = eight(4.2);
    assert!(crossed.settled.is_empty() && crossed.pieces[0].frozen);
    assert_eq!(figure(&crossed, "unfit_pieces"), Some(1.0));
    let told = crossed.warnings.iter().filter(|told| told.contains("stay deforming")).count();
    assert_eq!((told, open.warnings.len() + 1), (1, crossed.warnings.len()));
}

/// What is gone is as if it were far away: the other part goes through where it was.
#[test]
fn a_part_that_is_gone_is_nowhere() {
    let cut = CutSheet::two();
    let state = cut.moving(0);
    let gone = cut.solve(&state, retiring(1, 8, Some(vec![1])));
    let beside = cut.solve(&state, retiring(1, 8, None));
    let mut apart = state.clone();
    nodes(&state, 1).into_iter().for_each(|n| apart.domain.displacement[n][2] += 10.0);
    let apart = cut.solve(&apart, retiring(1, 8, None));
    let end = cut.decode(&gone);
    assert!(motion(&end, 0) == motion(&cut.decode(&apart), 0));
    assert!(motion(&end, 0) != motion(&cut.decode(&beside), 0), "they never met");
    assert!(motion(&end, 1) == motion(&state, 1), "it lies where it lay");
    assert!(end.encode(wall(&cut.prepared)) == gone.state);
    assert!(end.pieces.iter().any(|piece| piece.number == 1 && piece.still == GONE));
    // It is in no list and no sum, and none of it is drawn; what left is told.
    assert_eq!(gone.pieces.iter().map(|piece| piece.number).collect::<Vec<_>>(), [0]);
    let left = figure(&gone, "retired_mass").unwrap();
    let offered = cut.solve(&cut.state, retiring(1, 1, Some(vec![]))).settled;
    assert!((left / 0.032 - 1.0).abs() < 1e-3, "{left}");
    assert!((left / offered[1].mass - 1.0).abs() < 1e-12, "{left}");
    assert!((gone.ledger.mass + left - beside.ledger.mass).abs() < 1e-12);
    assert!((gone.ledger.momentum[0] / (0.5 * gone.ledger.mass) - 1.0).abs() < 1e-9);
    assert!(gone.ledger.residual.abs() < 1e-9 * gone.ledger.kinetic, "{:?}", gone.ledger);
    // Control points lie half a cell out.
    let right = 0.03 + 0.5 * 8.0 * WORLD_STEP;
    assert!((gone.extent.high[0] - right).abs() < 1e-3, "{:?}", gone.extent);
    assert!(beside.extent.high[0] > 0.09);
    let drawn = |outcome: &WindowOutcome| {
        let (surface, frame) = (&outcome.surfaces[0], &outcome.frames[0]);
        assert_eq!(surface.reference.len(), frame.offsets.len());
        surface.triangles.len()
    };
    assert_eq!((drawn(&gone), drawn(&beside)), (2 * 6 * 5 * 4, 2 * 10 * 5 * 4));
    // Windows may be cut anywhere.
    let first = cut.solve(&state, retiring(1, 3, Some(vec![1])));
    let second = cut.solve(&cut.decode(&first), retiring(4, 5, Some(vec![])));
    assert!(second.state == gone.state && second.settled.is_empty());
    assert_eq!((second.pieces, figure(&first, "retired_mass")), (gone.pieces, Some(left)));
}

/// What a part stores leaves with it: it is no work of this window.
#[test]
fn the_energy_of_what_is_gone_is_told() {
    let cut = CutSheet::two();
    let mut state = cut.state.clone();
    nodes(&state, 1).into_iter().for_each(|n| {
        let first = state.domain.surface.nodes[state.domain.origin[n] as usize];
        state.domain.displacement[n][1] = 0.05 * first.y;
    });
    let stays = cut.solve(&state, retiring(1, 1, Some(vec![]))).ledger;
    let gone = cut.solve(&state, retiring(1, 1, Some(vec![1])));
    let stored = stays.stretching + stays.bending;
    let left = figure(&gone, "retired_energy").unwrap();
    // Uniaxial stress at a strain of 5 %, less what the free width narrows.
    assert!(left > 0.5 * 3.2e5 * 0.05 * 0.05 * 3.2e-5 * 0.9, "{left}");
    // Beside it the lips of the cut press on each other.
    assert!((left / stored - 1.0).abs() < 5e-3, "{left} of {stored}");
    assert_eq!((gone.ledger.stretching, gone.ledger.residual), (0.0, 0.0));
}

/// A corner of a cube of 0.02 m.
fn cube_corner(k: u32) -> Vec3 {
    Vec3::from([0, 1, 2].map(|axis| 0.02 * f64::from(k >> axis & 1) - 0.01))
}

/// Nothing is left: bodies go their way, and numbers stay numbers.
#[test]
fn a_window_of_nothing_moves_bodies_alone() {
    let cut = CutSheet::two();
    let cube = Proxy {
        body: 7,
        object: None,
        parts: vec![(0..8).map(cube_corner).collect()],
        friction: 0.3,
        pose: Pose::translation(0.0, 0.0, 0.03),
        velocity: Vec3::new(0.0, 0.0, -3.0),
        spin: Vec3::zeros(),
        motion: ProxyMotion::Free { mass: 0.02, inertia: Mat3::identity() * 2e-6 },
    };
    let through = |retired| {
        let window = Window { proxies: vec![cube.clone()], ..retiring(1, 4, retired) };
        cut.solve(&cut.state, window)
    };
    let gone = through(Some(vec![0, 1]));
    assert!(gone.pieces.is_empty() && gone.settled.is_empty());
    assert_eq!((gone.ledger.mass, gone.ledger.stretching, gone.ledger.residual), (0.0, 0.0, 0.0));
    assert!(gone.surfaces.iter().all(|surface| surface.triangles.is_empty()));
    assert!(gone.extent.high[0] > 0.09 && gone.extent.low[2].is_finite(), "{:?}", gone.extent);
    assert!(gone.figures.iter().all(|figure| figure.value.is_finite()), "{:?}", gone.figures);
    let end = |outcome: &WindowOutcome| outcome.handed[0].poses[3].translation.z;
    assert!((end(&gone) - (0.03 - 3.0 * 4.0 * WORLD_STEP)).abs() < 1e-12, "{}", end(&gone));
    assert!(gone.handed[0].impulses.iter().flatten().all(|j| j.norm() == 0.0));
    // What rests wakes for it.
    let hit = through(Some(vec![]));
    assert!(hit.handed[0].impulses.iter().any(|j| j[0].z > 0.0) && !hit.pieces[0].frozen);
}

/// Something that moves where a part lay that is gone wakes none that lies beside.
#[test]
fn what_comes_to_where_a_part_lay_wakes_no_other() {
    let cut = CutSheet::two();
    let beside = |retired| {
        let mover = Proxy {
            body: 3,
            object: None,
            parts: vec![(0..8).map(cube_corner).collect()],
            friction: 0.3,
            pose: Pose::translation(0.14, 0.0, 0.0),
            velocity: Vec3::new(0.0, 0.0, 0.1),
            spin: Vec3::zeros(),
            motion: ProxyMotion::Steady,
        };
        let window = Window { proxies: vec![mover], ..retiring(1, 4, Some(retired)) };
        cut.solve(&cut.state, window).pieces
    };
    let both = beside(vec![]);
    assert_eq!(both.iter().map(|piece| piece.frozen).collect::<Vec<_>>(), [true, false]);
    let left = beside(vec![1]);
    assert_eq!(left.iter().map(|p| (p.number, p.frozen)).collect::<Vec<_>>(), [(0, true)]);
}

#[test]
fn only_parts_at_rest_can_be_retired() {
    let cut = CutSheet::two();
    let refused = |state: &SoftShellState<9>, number: u32| {
        let bytes = state.encode(wall(&cut.prepared));
        let window = retiring(1, 1, Some(vec![number]));
        let run = SoftShellWindow::open(Arc::clone(&cut.prepared), Some(&bytes), window);
        run.err().map(|refusal| refusal.to_string()).unwrap_or_default()
    };
    let moving = cut.moving(0);
    assert!(refused(&moving, 0).contains("piece 0") && refused(&moving, 5).contains("piece 5"));
    assert_eq!(refused(&moving, 1), "");
    let gone = cut.decode(&cut.solve(&cut.state, retiring(1, 1, Some(vec![1]))));
    let run = SoftShellWindow::open(
        Arc::clone(&cut.prepared),
        Some(&gone.encode(wall(&cut.prepared))),
        retiring(2, 1, Some(vec![1])),
    );
    assert!(run.err().is_some_and(|refusal| refusal.to_string().contains("piece 1")));
}
