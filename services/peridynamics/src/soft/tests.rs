//! Soft solids against formulas and against themselves.

mod breaking;
mod elastic;
mod motion;
mod retire;

use super::prepared::PreparedSoftSolid;
use super::window::SoftSolidWindow;
use cullet_geometry::shapes::{Detail, cuboid};
use cullet_geometry::{Pose, Solid, Vec3};
use cullet_model::{
    BodyGrip, BodyRegion, BondedSolid, Continuum, ContinuumBody, ContinuumSetup, Failure, Material,
    MembranePace, Proxy, SheetAir, SoftBody, SoftLaw, Window, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// Step of the world in these tests \[s\].
const WORLD_STEP: f64 = 1.0 / 240.0;

/// Bonds that only stretch.
fn elastic() -> BondedSolid {
    BondedSolid { breaks: false, horizon: 2.5, ..BondedSolid::default() }
}

/// A block of jelly about the origin, at rest, without gravity, air and damping.
fn block(size: [f64; 3], spacing: f64, bonds: BondedSolid) -> ContinuumSetup {
    let mesh = cuboid(Vec3::from(size), Detail::default()).unwrap();
    let material = Material {
        density: 1000.0,
        young: 5e4,
        poisson: 0.25,
        failure_stress: 1e4,
        fracture_energy: 5.0,
    };
    let air =
        SheetAir { density: 0.0, drag: 0.0, wind: Vec3::zeros(), gusts: [0.0; 2], pressure: 0.0 };
    let body = SoftBody {
        solid: Arc::new(Solid::outer(mesh)),
        material,
        law: SoftLaw::Bonded(bonds),
        spacing,
        damping: 0.0,
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        grips: vec![],
        cuts: vec![],
        air,
        pace: MembranePace::Real,
    };
    ContinuumSetup {
        body: ContinuumBody::Soft(body),
        world_step: WORLD_STEP,
        gravity: Vec3::zeros(),
        seed: 7,
    }
}

fn body(setup: &mut ContinuumSetup) -> &mut SoftBody {
    let ContinuumBody::Soft(body) = &mut setup.body else { unreachable!() };
    body
}

/// A grip on all beyond a plane across x.
fn end_grip(from: f64, to: f64, path: Vec<(f64, Vec3)>) -> BodyGrip {
    let region =
        BodyRegion::Box { low: Vec3::new(from, -9.0, -9.0), high: Vec3::new(to, 9.0, 9.0) };
    BodyGrip { region, path, turn: Vec3::zeros(), until: None }
}

fn prepared(setup: &ContinuumSetup) -> Arc<PreparedSoftSolid> {
    Arc::new(SoftSolidWindow::prepare(setup).unwrap())
}

fn window(first_step: u64, steps: u32, proxies: Vec<Proxy>) -> Window {
    Window { first_step, steps, frame_every: 4, proxies, retired: None }
}

/// Runs a window to its end.
fn solved(
    prepared: &Arc<PreparedSoftSolid>,
    state: Option<&[u8]>,
    window: Window,
) -> Result<WindowOutcome, Failure> {
    let mut run = SoftSolidWindow::open(Arc::clone(prepared), state, window).unwrap();
    loop {
        match run.advance() {
            WindowProgress::Running(_) => {}
            WindowProgress::Done(outcome) => return Ok(*outcome),
            WindowProgress::Failed(failure) => return Err(failure),
        }
    }
}

/// A body takes memory by its points: the cache of prepared bodies counts on it.
#[test]
fn memory_goes_with_the_number_of_points() {
    let of = |side: f64| {
        let prepared = prepared(&block([side, side, side], 0.01, elastic()));
        SoftSolidWindow::bytes(&prepared) as f64 / prepared.rest.len() as f64
    };
    let [few, many] = [0.08, 0.16].map(of);
    assert!((0.7..1.5).contains(&(many / few)), "{few} and {many} bytes a point");
    assert!((500.0..10_000.0).contains(&many), "{many} bytes a point");
}

fn figure(outcome: &WindowOutcome, name: &str) -> f64 {
    outcome.figures.iter().find(|figure| figure.name == name).unwrap().value
}
