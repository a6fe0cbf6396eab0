//! The rows of a run of the whole: what its probes read after each step of the world.

use super::books::{Books, Entries, Fold};
use super::state::{PartMotion, RecordedPart, ReplayState};
use crate::specimen::whole::format::SceneProbeKind;
use crate::specimen::whole::{ResolvedProbe, Whole};
use cullet_geometry::{Mat3, Vec3};
use cullet_record::Recording;
use cullet_specimen::{SpecimenOutcome, TensorPart as Component};

/// Most samples of a run: of a longer one every second step is read, or every third.
const MOST: u64 = 1_000_000;

/// Fills in what a recording says.
pub(super) fn fill(result: &mut SpecimenOutcome, whole: &Whole, recording: &Recording) {
    let last = recording.events.last().map_or(0, |event| event.step);
    result.steps = last;
    result.points = recording.reports.iter().map(|report| report.particles).sum();
    let ratios = recording.reports.iter().map(|report| report.strength_ratio);
    result.strength_ratio = ratios.filter(|ratio| *ratio > 0.0).fold(1.0, f64::min);
    let stride = last.div_ceil(MOST).max(1);
    let mut steps: Vec<u64> = (0..=last).step_by(stride as usize).collect();
    if steps.last() != Some(&last) {
        steps.push(last);
    }
    result.times = steps.iter().map(|step| *step as f64 * whole.step).collect();
    result.rows = rows(&whole.watches, recording, &steps);
}

pub(super) fn rows(
    watches: &[ResolvedProbe],
    recording: &Recording,
    steps: &[u64],
) -> Vec<Vec<f64>> {
    let books = Books::new(recording);
    let told: Vec<Option<(Fold, Entries)>> = watches.iter().map(|w| books.entries(w)).collect();
    let mut rows: Vec<Vec<f64>> = told
        .iter()
        .map(|told| told.as_ref().map(|(fold, entries)| course(*fold, entries, steps)))
        .map(Option::unwrap_or_default)
        .collect();
    let mut state = ReplayState::new(recording);
    for &step in steps {
        state.play(step);
        for ((watch, row), _) in
            watches.iter().zip(&mut rows).zip(&told).filter(|(_, told)| told.is_none())
        {
            row.push(read(&state, watch));
        }
    }
    for (watch, row) in watches.iter().zip(&mut rows) {
        if watch.kind == SceneProbeKind::Balance {
            let first = row.first().copied().unwrap_or_default();
            let all = |kind| ResolvedProbe { kind, ..watch.clone() };
            let lost = [SceneProbeKind::HitLoss, SceneProbeKind::BreakLoss].map(|kind| {
                let (fold, entries) = books.entries(&all(kind)).unwrap_or((Fold::Sum, Vec::new()));
                course(fold, &entries, steps)
            });
            for (k, value) in row.iter_mut().enumerate() {
                *value += lost[0][k] + lost[1][k] - first;
            }
        }
    }
    rows
}

/// Values of events as a row of samples.
fn course(fold: Fold, entries: &[(u64, f64)], steps: &[u64]) -> Vec<f64> {
    let mut entries = entries.iter().peekable();
    let mut value = if fold == Fold::One { f64::NAN } else { 0.0 };
    let mut row = Vec::with_capacity(steps.len());
    for &step in steps {
        while let Some((_, number)) = entries.next_if(|(at, _)| *at <= step) {
            value = match fold {
                Fold::Sum => value + number,
                Fold::Most => number.max(value),
                Fold::One => *number,
            };
        }
        row.push(value);
    }
    row
}

/// What a probe of bodies reads.
fn read(state: &ReplayState<'_>, watch: &ResolvedProbe) -> f64 {
    let parts = || state.parts(watch.bodies.as_ref());
    let sum = |number: &dyn Fn(&RecordedPart, &PartMotion) -> f64| {
        parts().map(|(p, r)| number(p, r)).sum::<f64>()
    };
    let vector = |number: &dyn Fn(&RecordedPart, &PartMotion) -> Vec3| {
        parts().map(|(part, row)| number(part, row)).fold(Vec3::zeros(), |all, one| all + one)
    };
    let mass = || sum(&|part, _| part.mass);
    let kinetic = || sum(&kinetic);
    let potential = || sum(&|part, row| -part.mass * state.gravity.dot(&row.at));
    let bodies = || parts().filter(|(part, _)| !part.grain);
    match watch.kind {
        SceneProbeKind::Position => along(vector(&|p, r| r.at * p.mass) / mass(), watch.part),
        SceneProbeKind::Velocity => along(vector(&|p, r| r.velocity * p.mass) / mass(), watch.part),
        SceneProbeKind::Displacement => displacement(state, watch),
        SceneProbeKind::Spin => {
            let mut wholes = parts().filter(|(part, _)| part.whole);
            match (wholes.next(), wholes.next()) {
                (Some((_, row)), None) => along(row.spin, watch.part),
                _ => f64::NAN,
            }
        }
        SceneProbeKind::Mass => mass(),
        SceneProbeKind::Volume => sum(&|part, _| part.volume),
        SceneProbeKind::Inertia => {
            let centre = vector(&|p, r| r.at * p.mass) / mass();
            let all =
                parts().map(|(part, row)| part.inertia(row) + part.mass * lever(row.at - centre));
            moment(&all.fold(Mat3::zeros(), |all, one| all + one), watch.part)
        }
        SceneProbeKind::Momentum => along(vector(&|p, r| r.velocity * p.mass), watch.part),
        SceneProbeKind::AngularMomentum => {
            let own = |part: &RecordedPart, row: &PartMotion| {
                part.inertia(row) * row.spin + part.mass * row.at.cross(&row.velocity)
            };
            along(vector(&own), watch.part)
        }
        SceneProbeKind::Kinetic => kinetic(),
        SceneProbeKind::Potential => potential(),
        SceneProbeKind::Energy | SceneProbeKind::Balance => kinetic() + potential(),
        SceneProbeKind::Bodies => bodies().count() as f64,
        SceneProbeKind::Pieces => {
            let least = watch.share * mass();
            bodies().filter(|(part, _)| part.mass >= least).count() as f64
        }
        SceneProbeKind::Largest => bodies().map(|(part, _)| part.mass).fold(0.0, f64::max) / mass(),
        // All others are read off events.
        _ => f64::NAN,
    }
}

fn kinetic(part: &RecordedPart, row: &PartMotion) -> f64 {
    let turning = row.spin.dot(&(part.inertia(row) * row.spin));
    0.5 * (part.mass * row.velocity.norm_squared() + turning)
}

/// The displacement of the body of the scene that has the greatest one in that component.
fn displacement(state: &ReplayState<'_>, watch: &ResolvedProbe) -> f64 {
    let wholes = state.parts(watch.bodies.as_ref()).filter(|(part, _)| part.whole);
    let moved = wholes.map(|(part, row)| along(row.at - part.first.unwrap_or(row.at), watch.part));
    moved.fold(f64::NAN, |most, one| if one.abs() <= most.abs() { most } else { one })
}

/// ∫ (|r|² 1 − r rᵀ) for a unit mass at r.
fn lever(r: Vec3) -> Mat3 {
    Mat3::identity() * r.norm_squared() - r * r.transpose()
}

fn along(vector: Vec3, part: Component) -> f64 {
    match part {
        Component::Axis(k) => vector[k as usize],
        _ => vector.norm(),
    }
}

fn moment(tensor: &Mat3, part: Component) -> f64 {
    let principal = || tensor.symmetric_eigenvalues();
    match part {
        Component::Pair(k) => {
            let (i, j) = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)][k as usize % 6];
            tensor[(i, j)]
        }
        Component::Greatest => principal().max(),
        Component::Least => principal().min(),
        Component::Mean => tensor.trace() / 3.0,
        _ => tensor.norm(),
    }
}
