//! Soft solids for some tenths of a second: what they cost and whether their books close.
//!
//! `cargo run --release -p cullet-peridynamics --example soft -- jello 1.2 folder` (or `limb`, or
//! `twist`) prints the ledger by tenths of a second; with a folder it writes each frame there as an
//! OBJ.

use cullet_geometry::boolean::Exact;
use cullet_geometry::shapes::{Detail, cuboid};
use cullet_geometry::{Pose, Quat, Solid, TriMesh, Vec3};
use cullet_model::{
    BodyCut, BodyGrip, BodyRegion, BondedSolid, Continuum, ContinuumBody, ContinuumSetup, Material,
    MembranePace, Proxy, ProxyMotion, SheetAir, SoftBody, SoftLaw, Window, WindowOutcome,
    WindowProgress,
};
use cullet_peridynamics::SoftSolidWindow;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Step of the world \[s\].
const WORLD_STEP: f64 = 1.0 / 240.0;
/// Steps of a window and between frames.
const STEPS: u32 = 24;
const FRAME_EVERY: u32 = 8;

/// What is run, and the rigid bodies beside it.
struct Case {
    setup: ContinuumSetup,
    proxies: Vec<Proxy>,
    /// How long \[s\].
    length: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_default();
    let mut case = match name.as_str() {
        "jello" => jello()?,
        "limb" => limb()?,
        "twist" => twist()?,
        other => return Err(format!("`{other}` is no case: take jello, limb or twist").into()),
    };
    if let Some(length) = words.next() {
        case.length = length.parse()?;
    }
    let folder = words.next();
    let begun = Instant::now();
    let prepared = Arc::new(SoftSolidWindow::prepare(&case.setup)?);
    println!("prepared in {:.2} s", begun.elapsed().as_secs_f64());
    let windows = (case.length / (f64::from(STEPS) * WORLD_STEP)).ceil() as u64;
    let (mut state, begun) = (None, Instant::now());
    for number in 0..windows {
        let first_step = number * u64::from(STEPS);
        let proxies = case.proxies.clone();
        let window =
            Window { first_step, steps: STEPS, frame_every: FRAME_EVERY, proxies, retired: None };
        let mut run = SoftSolidWindow::open(Arc::clone(&prepared), state.as_deref(), window)?;
        let outcome = loop {
            match run.advance() {
                WindowProgress::Running(_) => {}
                WindowProgress::Done(outcome) => break outcome,
                WindowProgress::Failed(failure) => return Err(failure.into()),
            }
        };
        if number == 0 {
            for figure in &outcome.figures {
                println!("{} {:.4e} {}", figure.name, figure.value, figure.unit);
            }
        }
        report(&outcome, (number + 1) as f64 * f64::from(STEPS) * WORLD_STEP);
        if let Some(folder) = &folder {
            write(&outcome, Path::new(folder))?;
        }
        follow(&mut case.proxies, &outcome);
        state = Some(outcome.state);
    }
    let (took, film) = (begun.elapsed().as_secs_f64(), windows as f64 * 0.1);
    println!("{took:.1} s for {film:.1} s of film: {:.1} s a second", took / film);
    Ok(())
}

/// A line of the ledger.
fn report(outcome: &WindowOutcome, time: f64) {
    let it = &outcome.ledger;
    println!(
        "{time:.1} s: kinetic {:.3e}, stored {:.3e}, broken {:.2e}, plastic {:.2e}, damped {:.2e}, \
         air {:.2e}, grips {:.2e}, gravity {:.2e}, bodies {:.2e}, residual {:.1e} J; torn {:.2e} \
         m², pieces {}, bytes {}",
        it.kinetic,
        it.stretching,
        it.broken,
        it.plastic,
        it.damped,
        it.air,
        it.grips,
        it.gravity,
        it.bodies,
        it.residual,
        it.torn_area,
        outcome.pieces.len(),
        outcome.state.len()
    );
    outcome.warnings.iter().for_each(|warning| println!("  {warning}"));
}

/// Rigid bodies go on as the window left them.
fn follow(proxies: &mut [Proxy], outcome: &WindowOutcome) {
    for (proxy, handed) in proxies.iter_mut().zip(&outcome.handed) {
        let last = &handed.poses[handed.poses.len().saturating_sub(2)..];
        if let ([before, now], ProxyMotion::Free { .. }) = (last, &proxy.motion) {
            proxy.velocity = (now.translation.vector - before.translation.vector) / WORLD_STEP;
            proxy.pose = *now;
        }
    }
}

/// Writes the frames of a window.
fn write(outcome: &WindowOutcome, folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    for frame in &outcome.frames {
        let mut text = String::new();
        for x in &frame.offsets {
            let x = frame.origin + Vec3::from(x.map(f64::from));
            writeln!(text, "v {} {} {}", x.x, x.y, x.z)?;
        }
        for t in &outcome.surfaces[frame.surface as usize].triangles {
            let [a, b, c] = t.map(|v| v + 1);
            writeln!(text, "f {a} {b} {c}")?;
        }
        std::fs::write(folder.join(format!("{:05}.obj", frame.step)), text)?;
    }
    Ok(())
}

/// A body of this shape, at rest, with what most have in common.
fn soft(mesh: TriMesh, spacing: f64, bonds: BondedSolid) -> SoftBody {
    SoftBody {
        solid: Arc::new(Solid::outer(mesh)),
        material: Material {
            density: 1000.0,
            young: 3e4,
            poisson: 0.35,
            failure_stress: 1e4,
            fracture_energy: 30.0,
        },
        law: SoftLaw::Bonded(bonds),
        spacing,
        damping: 0.1,
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

fn setup(body: SoftBody) -> ContinuumSetup {
    let body = ContinuumBody::Soft(body);
    ContinuumSetup { body, world_step: WORLD_STEP, gravity: Vec3::z() * -9.81, seed: 1 }
}

fn bonds() -> BondedSolid {
    BondedSolid { horizon: 2.3, air_damping: 0.5, ..BondedSolid::default() }
}

/// A block of jelly, cut aslant, falls on a plate and wobbles.
fn jello() -> Result<Case, Box<dyn Error>> {
    let size = Vec3::new(0.14, 0.10, 0.08);
    let mut body = soft(cuboid(size, Detail::default())?, 0.006, bonds());
    body.pose = Pose::from_parts(
        Vec3::new(0.0, 0.0, 0.09).into(),
        Quat::from_scaled_axis(Vec3::new(0.1, 0.25, 0.0)),
    );
    let corner = |y: f64, z: f64| Vec3::new(0.015 + 0.5 * z, y, z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    body.cuts = vec![BodyCut { corners }];
    body.material.fracture_energy = 100.0;
    let plate = cuboid(Vec3::new(1.0, 1.0, 0.1), Detail::default())?;
    let plate = Proxy {
        body: 1,
        parts: vec![plate.vertices],
        friction: 0.3,
        pose: Pose::translation(0.0, 0.0, -0.05),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        motion: ProxyMotion::Steady,
    };
    Ok(Case { setup: setup(body), proxies: vec![plate], length: 1.2 })
}

/// A block with a limb that a grip tears off.
fn limb() -> Result<Case, Box<dyn Error>> {
    let trunk = cuboid(Vec3::new(0.12, 0.12, 0.12), Detail::default())?;
    let arm = cuboid(Vec3::new(0.16, 0.045, 0.045), Detail::default())?;
    let arm = arm.translated(Vec3::new(0.11, 0.0, 0.02));
    let [trunk, arm] = [trunk, arm].map(|mesh| Exact::new(&Solid::outer(mesh)));
    let mesh = trunk?.union(&arm?)?.mesh();
    let mut body = soft(mesh, 0.007, bonds());
    body.material.young = 1.2e5;
    body.material.fracture_energy = 150.0;
    let grip = |low: f64, high: f64, path| BodyGrip {
        region: BodyRegion::Box {
            low: Vec3::new(low, -1.0, -1.0),
            high: Vec3::new(high, 1.0, 1.0),
        },
        path,
        turn: Vec3::zeros(),
        until: None,
    };
    let path = vec![(0.0, Vec3::zeros()), (1.0, Vec3::new(0.2, 0.0, 0.03))];
    body.grips = vec![grip(-0.07, -0.045, vec![]), grip(0.165, 0.2, path)];
    Ok(Case { setup: setup(body), proxies: vec![], length: 1.2 })
}

/// A beam that is twisted by half a turn and let go.
fn twist() -> Result<Case, Box<dyn Error>> {
    let size = Vec3::new(0.30, 0.05, 0.05);
    let mut body =
        soft(cuboid(size, Detail::default())?, 0.006, BondedSolid { breaks: false, ..bonds() });
    body.material.young = 5e4;
    let region = |low: f64, high: f64| BodyRegion::Box {
        low: Vec3::new(low, -1.0, -1.0),
        high: Vec3::new(high, 1.0, 1.0),
    };
    let hold =
        BodyGrip { region: region(-0.16, -0.135), path: vec![], turn: Vec3::zeros(), until: None };
    let turning = BodyGrip {
        region: region(0.135, 0.16),
        path: vec![(0.0, Vec3::zeros()), (0.5, Vec3::zeros())],
        turn: Vec3::new(std::f64::consts::TAU, 0.0, 0.0),
        until: Some(0.6),
    };
    body.grips = vec![hold, turning];
    Ok(Case { setup: setup(body), proxies: vec![], length: 1.2 })
}
