//! A specimen, from the wire to its result.

use crate::convert::{region_of, strength_of};
use cullet_fracture::mpm::domain::Fields;
use cullet_fracture::specimen as bench;
use cullet_geometry::{Mat3, Quat, Vec3};
use cullet_model as core;
use cullet_model::Precision;
use cullet_proto::specimen as wire;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Solves a specimen with the threads that it asks for. What goes wrong is how it ended.
#[must_use]
pub fn solve(job: &wire::SpecimenJob) -> wire::SpecimenResult {
    let threads = job.setup.settings.threads.clamp(1, 256) as usize;
    let start = Instant::now();
    let work = || catch_unwind(AssertUnwindSafe(|| advance(specimen_of(job))));
    let mut result = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work).unwrap_or_else(|_| {
            let text = "the solver panicked".to_owned();
            wire::SpecimenResult::ended(wire::Ending::Crashed(text))
        }),
        Err(error) => wire::SpecimenResult::ended(wire::Ending::Crashed(error.to_string())),
    };
    result.price =
        wire::Price { wall: start.elapsed().as_secs_f64(), cpu: cpu_time(), peak: peak_memory() };
    result
}

fn advance(specimen: bench::Specimen) -> wire::SpecimenResult {
    let mut run = match bench::SpecimenRun::begin(specimen) {
        Ok(run) => run,
        Err(refusal) => {
            return wire::SpecimenResult::ended(wire::Ending::Refused(refusal.to_string()));
        }
    };
    loop {
        if let bench::Step::Done(outcome) = run.advance() {
            return result_of(*outcome);
        }
    }
}

fn result_of(outcome: bench::Outcome) -> wire::SpecimenResult {
    let ending = match outcome.ending {
        bench::Ending::Done => wire::Ending::Ok,
        bench::Ending::NotFinite { step } => {
            wire::Ending::NotFinite(format!("a value is not finite at step {step}"))
        }
        bench::Ending::Unstable { ratio, step } => {
            wire::Ending::Unstable(format!("{ratio:.3} of the energy put in at step {step}"))
        }
    };
    let frame = |f: bench::Frame| wire::Frame { time: f.time, points: f.points };
    wire::SpecimenResult {
        ending,
        step: outcome.step,
        steps: outcome.steps,
        points: outcome.points,
        strength_ratio: outcome.strength_ratio,
        price: wire::Price::default(),
        pieces: outcome.pieces,
        times: outcome.times,
        rows: outcome.rows,
        frames: outcome.frames.into_iter().map(frame).collect(),
    }
}

fn specimen_of(job: &wire::SpecimenJob) -> bench::Specimen {
    let s = &job.setup;
    let zone = |zone: &wire::Zone| bench::Zone {
        part: where_of(&zone.part),
        material: material_of(&zone.material),
    };
    let [w, i, j, k] = s.turn;
    bench::Specimen {
        mesh: job.solid.mesh.clone(),
        turn: Quat::new_normalize([i, j, k, w].into()),
        shift: Vec3::from(s.shift),
        bodies: s.bodies.clone(),
        material: material_of(&s.material),
        zones: s.zones.iter().map(zone).collect(),
        strength: even(strength_of(&s.strength)),
        patches: s.patches.iter().map(patch_of).collect(),
        notches: s.notches.iter().map(notch_of).collect(),
        symmetries: s.symmetries.iter().map(|&(a, at)| (usize::from(a.min(2)), at)).collect(),
        stretch: matrix(&s.stretch),
        starts: s.starts.iter().map(start_of).collect(),
        holds: s.holds.iter().map(hold_of).collect(),
        loads: s.loads.iter().map(load_of).collect(),
        probes: s.probes.iter().map(probe_of).collect(),
        settings: settings_of(&s.settings),
        end: s.end,
        samples: s.samples,
        frames: s.frames,
        colour: (field_of(s.colour.0), part_of(s.colour.1)),
    }
}

fn even(field: core::StrengthField) -> core::StrengthField {
    let weibull =
        if field.weibull < cullet_proto::strength::EVEN { field.weibull } else { f64::INFINITY };
    core::StrengthField { weibull, ..field }
}

fn material_of(m: &cullet_proto::Material) -> core::Material {
    core::Material {
        density: m.density,
        young: m.young,
        poisson: m.poisson,
        failure_stress: m.failure_stress,
        fracture_energy: m.fracture_energy,
    }
}

fn where_of(part: &wire::Where) -> bench::Where {
    part.iter().map(region_of).collect()
}

fn matrix(rows: &[[f64; 3]; 3]) -> Mat3 {
    Mat3::from_fn(|i, j| rows[i][j])
}

fn course_of(course: &wire::Course) -> bench::Amplitude {
    match course {
        wire::Course::Table(rows) => bench::Amplitude::Table(rows.clone()),
        &wire::Course::HalfSine(start, duration) => bench::Amplitude::HalfSine { start, duration },
    }
}

fn patch_of(patch: &wire::Patch) -> bench::Patch {
    let (strength, damage) = (patch.strength, patch.damage);
    bench::Patch { part: where_of(&patch.part), strength, damage }
}

fn notch_of(notch: &wire::Notch) -> bench::Notch {
    bench::Notch {
        point: Vec3::from(notch.point),
        normal: Vec3::from(notch.normal),
        part: where_of(&notch.part),
    }
}

fn start_of(start: &wire::Start) -> bench::Start {
    bench::Start {
        part: where_of(&start.part),
        velocity: Vec3::from(start.velocity),
        gradient: matrix(&start.gradient),
        centre: Vec3::from(start.centre),
        noise: start.noise,
    }
}

fn hold_of(hold: &wire::Hold) -> bench::DirichletBc {
    bench::DirichletBc {
        part: where_of(&hold.part),
        axes: hold.axes,
        velocity: Vec3::from(hold.velocity),
        gradient: matrix(&hold.gradient),
        centre: Vec3::from(hold.centre),
        course: course_of(&hold.course),
        until: hold.until.unwrap_or(f64::INFINITY),
    }
}

fn load_of(load: &wire::Load) -> bench::Load {
    let push = match load.push {
        wire::Push::Traction(v) => bench::LoadKind::Traction(Vec3::from(v)),
        wire::Push::Pressure(p) => bench::LoadKind::Pressure(p),
        wire::Push::Force(v) => bench::LoadKind::Force(Vec3::from(v)),
        wire::Push::Acceleration(v) => bench::LoadKind::Acceleration(Vec3::from(v)),
    };
    bench::Load { part: where_of(&load.part), push, course: course_of(&load.course) }
}

fn field_of(field: wire::Field) -> bench::Field {
    match field {
        wire::Field::Displacement => bench::Field::Displacement,
        wire::Field::Velocity => bench::Field::Velocity,
        wire::Field::Stress => bench::Field::Stress,
        wire::Field::Strain => bench::Field::Strain,
        wire::Field::Damage => bench::Field::Damage,
    }
}

fn part_of(part: wire::Part) -> bench::Part {
    match part {
        wire::Part::Axis(k) => bench::Part::Axis(k.into()),
        wire::Part::Pair(k) => bench::Part::Pair(k.into()),
        wire::Part::Size => bench::Part::Size,
        wire::Part::Greatest => bench::Part::Greatest,
        wire::Part::Least => bench::Part::Least,
        wire::Part::Mises => bench::Part::Mises,
        wire::Part::Mean => bench::Part::Mean,
    }
}

fn spot_of(spot: &wire::Spot) -> bench::Spot {
    match spot {
        wire::Spot::At(x) => bench::Spot::At(Vec3::from(*x)),
        wire::Spot::Over(part, reduce) => {
            let reduce = match reduce {
                wire::Reduce::Mean => bench::Reduce::Mean,
                wire::Reduce::Max => bench::Reduce::Max,
                wire::Reduce::Min => bench::Reduce::Min,
            };
            bench::Spot::Over(where_of(part), reduce)
        }
    }
}

fn probe_of(probe: &wire::Probe) -> bench::Probe {
    match probe {
        wire::Probe::Points(field, part, spot) => {
            bench::Probe::Points(field_of(*field), part_of(*part), spot_of(spot))
        }
        &wire::Probe::Reaction(hold, part) => bench::Probe::Reaction(hold as usize, part_of(part)),
        &wire::Probe::Applied(load, part) => bench::Probe::Applied(load as usize, part_of(part)),
        wire::Probe::Kinetic => bench::Probe::Kinetic,
        wire::Probe::Elastic => bench::Probe::Elastic,
        wire::Probe::Dissipated => bench::Probe::Dissipated,
        wire::Probe::Damped => bench::Probe::Damped,
        wire::Probe::Met => bench::Probe::Met,
        wire::Probe::Work => bench::Probe::Work,
        wire::Probe::Balance => bench::Probe::Balance,
        wire::Probe::Momentum(part) => bench::Probe::Momentum(part_of(*part)),
        wire::Probe::AngularMomentum(part) => bench::Probe::AngularMomentum(part_of(*part)),
        wire::Probe::Broken(part) => bench::Probe::Broken(where_of(part)),
        wire::Probe::DamagedVolume(part, bound) => {
            bench::Probe::DamagedVolume(where_of(part), *bound)
        }
        wire::Probe::CrackArea(part, normal) => {
            bench::Probe::CrackArea(where_of(part), Vec3::from(*normal))
        }
        wire::Probe::CrackTip(part, along, share, otherwise) => bench::Probe::CrackTip {
            part: where_of(part),
            along: Vec3::from(*along),
            share: *share,
            otherwise: *otherwise,
        },
        wire::Probe::CrackAngle(part, about, directions) => {
            bench::Probe::CrackAngle(where_of(part), Vec3::from(*about), directions.map(Vec3::from))
        }
        wire::Probe::Pieces(share) => bench::Probe::Pieces(*share),
        wire::Probe::Largest => bench::Probe::Largest,
    }
}

fn settings_of(s: &wire::Settings) -> bench::Settings {
    bench::Settings {
        spacing: s.spacing,
        step_factor: s.step_factor,
        per_cell: s.per_cell,
        points: if s.rows { bench::Points::Rows } else { bench::Points::Scattered },
        precision: if s.single { Precision::Single } else { Precision::Double },
        fields: if s.welded { Fields::Single } else { Fields::Split },
        breaks: s.breaks,
        softening_length: s.softening_length,
        damping: s.damping,
        damped_until: s.damped_until.unwrap_or(f64::INFINITY),
        max_points: s.max_points,
        max_steps: s.max_steps,
        seed: s.seed,
        look: s.look.into(),
    }
}

/// Ticks a second of the times in `/proc`: the same on every Linux.
const TICKS: f64 = 100.0;

/// Processor time of this process so far \[s\]; 0 where the system does not tell.
fn cpu_time() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let rest = text.rsplit(')').next().unwrap_or_default();
    let fields: Vec<f64> = rest.split_whitespace().map(|f| f.parse().unwrap_or(0.0)).collect();
    // After the name: the state, ten more, then user and system time.
    fields.get(11..13).map_or(0.0, |times| times.iter().sum::<f64>() / TICKS)
}

/// Most memory of this process so far \[bytes\]; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let size = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    size.unwrap_or(0) * 1024
}
