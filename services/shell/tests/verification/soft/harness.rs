//! Sheets and windows for the tests.

use cullet_geometry::shapes::{Detail, cuboid, sphere};
use cullet_geometry::{Mat3, Pose, Quat, Solid, Vec3};
use cullet_model::{
    BodyGrip, BodyRegion, Continuum, ContinuumBody, ContinuumSetup, Material, MembranePace, Proxy,
    ProxyMotion, SheetAir, SoftBody, SoftLaw, Window, WindowOutcome, WindowProgress,
};
use cullet_shell::SoftShellWindow;
use std::sync::Arc;

pub(crate) const WHOLE: SoftLaw = SoftLaw::Shell { hardening: None, breaks: false };
pub(crate) const TEARS: SoftLaw = SoftLaw::Shell { hardening: None, breaks: true };

pub(crate) const RUBBER: Material = Material {
    density: 1000.0,
    young: 3.2e5,
    poisson: 0.3,
    failure_stress: 8e4,
    fracture_energy: 300.0,
};

type Prepared = Arc<<SoftShellWindow as Continuum>::Prepared>;

/// A sheet around the origin in the plane z = 0, in still emptiness.
pub(crate) fn sheet(size: [f64; 3], spacing: f64, law: SoftLaw, material: Material) -> SoftBody {
    let mesh = cuboid(Vec3::from(size), Detail::default()).unwrap();
    SoftBody {
        solid: Arc::new(Solid::outer(mesh)),
        material,
        law,
        spacing,
        damping: 0.0,
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        grips: vec![],
        cuts: vec![],
        air: SheetAir {
            density: 0.0,
            drag: 0.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        },
        pace: MembranePace::Real,
    }
}

/// Holds what lies between two places along x, all across.
pub(crate) fn grip_x(from: f64, to: f64, path: Vec<(f64, Vec3)>) -> BodyGrip {
    let region =
        BodyRegion::Box { low: Vec3::new(from, -9.0, -9.0), high: Vec3::new(to, 9.0, 9.0) };
    BodyGrip { region, path, turn: Vec3::zeros(), until: None }
}

pub(crate) fn setup(body: SoftBody, gravity: Vec3) -> ContinuumSetup {
    ContinuumSetup { body: ContinuumBody::Soft(body), world_step: 1.0 / 240.0, gravity, seed: 1 }
}

pub(crate) fn prepare(setup: &ContinuumSetup) -> Prepared {
    Arc::new(SoftShellWindow::prepare(setup).unwrap())
}

pub(crate) fn free_ball(radius: f64, mass: f64, place: Vec3, velocity: Vec3) -> Proxy {
    let inertia = Mat3::identity() * (0.4 * mass * radius * radius);
    Proxy {
        body: 5,
        object: None,
        parts: vec![sphere(radius, Detail { segments: 16, edge: None }).unwrap().vertices],
        friction: 0.3,
        pose: Pose::from_parts(place.into(), Quat::identity()),
        velocity,
        spin: Vec3::zeros(),
        motion: ProxyMotion::Free { mass, inertia },
    }
}

/// One window from a state.
pub(crate) fn solve(
    prepared: &Prepared,
    state: Option<&[u8]>,
    first_step: u64,
    steps: u32,
    proxies: Vec<Proxy>,
) -> WindowOutcome {
    let window = Window { first_step, steps, frame_every: steps, proxies, retired: None };
    let mut solve = SoftShellWindow::open(Arc::clone(prepared), state, window).unwrap();
    loop {
        match solve.advance() {
            WindowProgress::Running(share) => assert!((0.0..=1.0).contains(&share)),
            WindowProgress::Done(outcome) => return *outcome,
            WindowProgress::Failed(failure) => panic!("{failure:?}"),
        }
    }
}

/// The value of a figure.
pub(crate) fn figure(outcome: &WindowOutcome, name: &str) -> f64 {
    outcome.figures.iter().find(|figure| figure.name == name).expect(name).value
}

/// Where the vertices of the last frame are.
pub(crate) fn places(outcome: &WindowOutcome) -> Vec<Vec3> {
    let frame = outcome.frames.last().unwrap();
    frame.offsets.iter().map(|o| frame.origin + Vec3::from(o.map(f64::from))).collect()
}
