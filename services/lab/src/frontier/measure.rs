//! The runs of a chart, each in a process of its own, and what they cost.

use super::super::crew::in_order;
use super::super::process::{self, ProcessEnd, SceneCommand};
use super::super::table::precision_word;
use super::super::{Limits, Measured, SweepPoint, run_all, status};
use super::row::FrontierRow;
use super::set::{ChartWork, FINEST, FrontierChart, MASS, MOTT, PIECES, Planned};
use super::stats::mass_distance;
use cullet_pool::LinkError;
use cullet_proto::recording::EventKind;
use cullet_proto::specimen::SpecimenResult;
use cullet_record::{FragmentOrigin, RESOLVED_CELLS, Recording, Shares, Summary, fit};
use cullet_scene::format::Precision;
use cullet_scene::load;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Runs all of a chart; equal runs are run once. `say` gets each, as it ends: its number, how
/// many there are, and its row, for a scene still without its value.
///
/// # Errors
/// The pool does not start.
pub fn measure(
    chart: &FrontierChart,
    limits: &Limits,
    say: &mut dyn FnMut(usize, usize, &FrontierRow),
) -> Result<Vec<FrontierRow>, LinkError> {
    let mut first: BTreeMap<&str, usize> = BTreeMap::new();
    for (k, run) in chart.runs.iter().enumerate() {
        first.entry(&run.id).or_insert(k);
    }
    let mut order: Vec<usize> = first.values().copied().collect();
    order.sort_unstable();
    let of = |run: &Planned| first.get(run.id.as_str()).copied().unwrap_or_default();
    let mut told = 0;
    let mut tell = |row: &FrontierRow| {
        told += 1;
        say(told, order.len(), row);
    };
    let scene = chart.runs.iter().any(|run| matches!(run.work, ChartWork::Scene(..)));
    if scene {
        Ok(scenes(chart, &order, &of, limits, &mut tell))
    } else {
        specimens(chart, &order, &of, limits, &mut tell)
    }
}

/// What is known of a row before its run.
fn blank(chart: &FrontierChart, run: &Planned) -> FrontierRow {
    FrontierRow {
        chart: chart.name.clone(),
        option: run.option.clone(),
        along: run.along.clone(),
        seed: run.seed,
        standard: run.standard,
        bench: chart.bench.clone(),
        metric: run.metric.clone(),
        reference: chart.reference,
        ..FrontierRow::default()
    }
}

fn weighed(chart: &FrontierChart, row: &mut FrontierRow, value: f64) {
    row.value = Some(value).filter(|v| v.is_finite());
    row.error = row.value.map(|v| (v - chart.reference) / chart.scale);
}

fn specimens(
    chart: &FrontierChart,
    order: &[usize],
    of: &dyn Fn(&Planned) -> usize,
    limits: &Limits,
    tell: &mut dyn FnMut(&FrontierRow),
) -> Result<Vec<FrontierRow>, LinkError> {
    let point = |k: &usize| match &chart.runs[*k].work {
        ChartWork::Specimen(specimen) => {
            Some(SweepPoint { specimen: (**specimen).clone(), swept: vec![] })
        }
        ChartWork::Scene(..) => None,
    };
    let points: Vec<SweepPoint> = order.iter().filter_map(point).collect();
    let mut done: BTreeMap<usize, FrontierRow> = BTreeMap::new();
    run_all(&points, limits, &mut |index, result, _| {
        let row = row_of(chart, &chart.runs[order[index]], &points[index], result);
        tell(&row);
        done.insert(order[index], row);
    })?;
    let with = |run: &Planned| {
        let (own, same) = (blank(chart, run), done.get(&of(run)).cloned().unwrap_or_default());
        FrontierRow { option: own.option, along: own.along, standard: own.standard, ..same }
    };
    Ok(chart.runs.iter().map(with).collect())
}

fn row_of(
    chart: &FrontierChart,
    run: &Planned,
    point: &SweepPoint,
    result: SpecimenResult,
) -> FrontierRow {
    let settings = point.specimen.settings();
    let (spacing, per_cell, threads) =
        settings.map_or((0.0, 0.0, 1), |s| (s.spacing, s.points.per_cell, s.threads));
    let precision = settings.map_or("double", |s| precision_word(s.precision)).to_owned();
    let (out, price) = (&result.outcome, result.price);
    let (step, steps) = (out.step, out.steps);
    let particle_steps = steps.saturating_mul(out.points);
    let word = status(&out.ending).to_owned();
    let measured = Measured::new(point.clone(), result);
    let found = measured.rows.iter().find(|row| row.metric == chart.metric);
    let mut row = FrontierRow {
        solver: point.specimen.solver.to_owned(),
        spacing,
        step,
        per_cell,
        precision,
        threads,
        wall: price.wall,
        cpu: price.cpu,
        steps,
        particle_steps,
        peak: price.peak,
        status: word,
        ..blank(chart, run)
    };
    weighed(chart, &mut row, found.map_or(f64::NAN, |row| row.value));
    row
}

/// The result of a scene's run, as charts measure it.
struct MeasuredRun {
    row: FrontierRow,
    /// What broke no further.
    parts: Vec<MeasuredPart>,
    /// What of it was sampled, not solved.
    shares: Option<Shares>,
}

impl MeasuredRun {
    /// The share of what was sampled that a run of a chart asks for.
    fn share(&self, run: &Planned) -> Option<f64> {
        let shares = self.shares.as_ref();
        match run.metric.as_str() {
            PIECES => Some(shares.map_or(f64::NAN, |shares| shares.sampled)),
            MASS => Some(shares.map_or(f64::NAN, |shares| shares.sampled_mass)),
            _ => None,
        }
    }
}

/// A body at the end of a run, as charts measure it.
#[derive(Clone)]
struct MeasuredPart {
    object: String,
    /// Whether it is broken off it.
    broken: bool,
    /// \[kg\]
    mass: f64,
    /// Mass of a cell of the solve that made it \[kg\]; 0 where it had no grid.
    cell: f64,
    /// Whether it was drawn from a law or directed, and not solved.
    sampled: bool,
}

fn scenes(
    chart: &FrontierChart,
    order: &[usize],
    of: &dyn Fn(&Planned) -> usize,
    limits: &Limits,
    tell: &mut dyn FnMut(&FrontierRow),
) -> Vec<FrontierRow> {
    let mut done: BTreeMap<usize, MeasuredRun> = BTreeMap::new();
    let work = |index: usize| scene(chart, &chart.runs[order[index]], limits);
    in_order(order.len(), limits.workers, &work, &mut |index, broken| {
        tell(&broken.row);
        done.insert(order[index], broken);
    });
    let all: Vec<(&Planned, Option<&MeasuredRun>)> =
        chart.runs.iter().map(|run| (run, done.get(&of(run)))).collect();
    let good = |broken: &Option<&MeasuredRun>| broken.is_some_and(|b| b.row.status == "ok");
    let finest: Vec<(u64, &MeasuredRun)> = all
        .iter()
        .filter(|(run, broken)| run.option == FINEST && good(broken))
        .filter_map(|(run, broken)| Some((run.seed, (*broken)?)))
        .collect();
    let laws = chart.metric == MOTT;
    let judges = || all.iter().filter(|(run, _)| laws || run.option == FINEST);
    let parts = judges().filter_map(|one| one.1).flat_map(|broken| &broken.parts);
    let mut objects: BTreeSet<&str> =
        parts.filter(|part| part.broken).map(|part| part.object.as_str()).collect();
    if let Some(object) = &chart.object {
        objects = [object.as_str()].into();
    }
    let of_objects = |broken: &MeasuredRun| -> Vec<MeasuredPart> {
        let its = |part: &&MeasuredPart| objects.contains(part.object.as_str());
        broken.parts.iter().filter(its).cloned().collect()
    };
    let masses: Vec<Vec<f64>> = finest.iter().map(|one| plain(&of_objects(one.1))).collect();
    let reference = masses.concat();
    let number = |parts: &[MeasuredPart]| match laws {
        true => mott(parts),
        false => mass_distance(&plain(parts), &reference),
    };
    // Of each point, its seeds and what they left; then the value of each.
    let mut points: BTreeMap<(&str, &str), Seeds> = BTreeMap::new();
    for (one, broken) in all.iter().filter(|one| one.0.option != FINEST && good(&one.1)) {
        let seeds = points.entry((one.option.as_str(), one.along.as_str())).or_default();
        seeds.extend(broken.map(|broken| (one.seed, of_objects(broken))));
    }
    let values: BTreeMap<(&str, &str), BTreeMap<u64, f64>> =
        points.into_iter().map(|(point, seeds)| (point, valued(seeds, &number))).collect();
    let row = |(run, broken): &(&Planned, Option<&MeasuredRun>)| {
        let own = blank(chart, run);
        let Some(broken) = broken else { return own };
        let mut row = named(own, &broken.row);
        let value = if row.status != "ok" {
            f64::NAN
        } else if let Some(share) = broken.share(run) {
            share
        } else if run.option == FINEST {
            let at = finest.iter().position(|(seed, _)| *seed == run.seed);
            halves(&masses, at.unwrap_or_default())
        } else {
            let point = (run.option.as_str(), run.along.as_str());
            values.get(&point).and_then(|seeds| seeds.get(&run.seed)).copied().unwrap_or(f64::NAN)
        };
        weighed(chart, &mut row, value);
        row
    };
    all.iter().map(row).collect()
}

/// A run's row under the names of another that asks for the same work.
fn named(own: FrontierRow, run: &FrontierRow) -> FrontierRow {
    let FrontierRow { option, along, standard, metric, .. } = own;
    FrontierRow { option, along, standard, metric, ..run.clone() }
}

/// Seeds of a point, and what each left.
type Seeds = Vec<(u64, Vec<MeasuredPart>)>;

/// The number of each seed of a point.
fn valued(seeds: Seeds, number: &dyn Fn(&[MeasuredPart]) -> f64) -> BTreeMap<u64, f64> {
    let (seeds, parts): (Vec<u64>, Vec<Vec<MeasuredPart>>) = seeds.into_iter().unzip();
    seeds.into_iter().zip(pooled(&parts, number)).collect()
}

fn plain(parts: &[MeasuredPart]) -> Vec<f64> {
    parts.iter().map(|part| part.mass).collect()
}

/// Kolmogorov's distance of the pieces that a solve resolved from Mott's law fitted to them; not a
/// number of fewer than three. Sampled pieces are drawn from that law, and say nothing of it.
fn mott(parts: &[MeasuredPart]) -> f64 {
    let is_solved = |part: &&MeasuredPart| part.broken && !part.sampled;
    let solved: Vec<MeasuredPart> = parts.iter().filter(is_solved).cloned().collect();
    let least = RESOLVED_CELLS * solved.iter().map(|part| part.cell).fold(0.0, f64::max);
    fit(&plain(&solved), least).map_or(f64::NAN, |fits| fits.mott.distance)
}

/// What each seed adds to a number of all seeds together, such that the mean over them is that
/// number and their scatter is the jackknife's: D + (n − 1)(D̄ − Dᵢ), with Dᵢ that of all others.
fn pooled<T: Clone>(seeds: &[Vec<T>], number: &dyn Fn(&[T]) -> f64) -> Vec<f64> {
    let of = |left: Option<usize>| {
        let kept = seeds.iter().enumerate().filter(|(k, _)| Some(*k) != left);
        number(&kept.flat_map(|(_, list)| list).cloned().collect::<Vec<T>>())
    };
    let n = seeds.len();
    let all = of(None);
    if n < 2 {
        return vec![all];
    }
    let others: Vec<f64> = (0..n).map(|k| of(Some(k))).collect();
    let mean = others.iter().sum::<f64>() / n as f64;
    others.iter().map(|own| all + (n - 1) as f64 * (mean - own)).collect()
}

/// The distance of two halves of the seeds, the first one beginning at one of them: how far chance
/// alone carries. Not a number of one seed.
fn halves(seeds: &[Vec<f64>], at: usize) -> f64 {
    let n = seeds.len();
    let half = |from: usize, count: usize| -> Vec<f64> {
        (0..count).flat_map(|k| seeds[(at + from + k) % n].iter().copied()).collect()
    };
    mass_distance(&half(0, n / 2), &half(n / 2, n - n / 2))
}

/// What the first solves of a scene are in.
fn precision(path: &Path, overrides: &[String]) -> &'static str {
    let asked = load(path, overrides).map(|scene| (scene.fracture.precision, scene.fidelity.error));
    match asked {
        Ok((Some(Precision::Single), _) | (None, Some(_))) => "single",
        _ => "double",
    }
}

/// Runs a scene with one worker of one thread, in a folder that goes again.
fn scene(chart: &FrontierChart, run: &Planned, limits: &Limits) -> MeasuredRun {
    let mut row = blank(chart, run);
    row.threads = 1;
    let (ChartWork::Scene(path, overrides), Ok(folder)) = (&run.work, tempfile::tempdir()) else {
        row.status = "crashed".to_owned();
        return MeasuredRun { row, parts: Vec::new(), shares: None };
    };
    row.precision = precision(path, overrides).to_owned();
    let out = folder.path().join("run");
    let exe = &limits.exe;
    let ran =
        process::run(SceneCommand { exe, scene: path, overrides, out: &out, limit: limits.time });
    row.status = match ran.end {
        ProcessEnd::Complete => "ok",
        ProcessEnd::Refused => "refused",
        ProcessEnd::Late => "timeout",
        ProcessEnd::Broken | ProcessEnd::NotFinite => "crashed",
    }
    .to_owned();
    (row.wall, row.cpu) = (ran.price.wall, ran.price.cpu);
    let (mut parts, mut shares) = (Vec::new(), None);
    let recording = out.join("run.mcap");
    if row.status == "ok" {
        match Recording::open(&recording) {
            Ok(opened) => {
                let report = opened.reports.first();
                row.spacing = report.map_or(0.0, |report| report.spacing);
                row.solver = report.map(|report| report.solver.clone()).unwrap_or_default();
                row.steps = opened.reports.iter().map(|r| r.steps).sum();
                row.particle_steps = opened.reports.iter().map(|r| r.steps * r.particles).sum();
                parts = parts_of(&opened);
                shares = shares_of(&out.join("summary.json"));
            }
            Err(_) => row.status = "crashed".to_owned(),
        }
    }
    MeasuredRun { row, parts, shares }
}

/// What a run says of itself that was sampled.
fn shares_of(summary: &Path) -> Option<Shares> {
    let text = std::fs::read_to_string(summary).ok()?;
    serde_json::from_str::<Summary>(&text).ok()?.shares
}

/// What broke no further, whole bodies with it.
fn parts_of(recording: &Recording) -> Vec<MeasuredPart> {
    let broken: BTreeSet<u64> = recording
        .events
        .iter()
        .filter(|event| event.kind() == EventKind::Fractured)
        .filter_map(|event| event.body)
        .collect();
    let spacing = recording.spacings();
    let origins = recording.origins();
    let found = |id| origins.get(&id).is_none_or(|origin| *origin == FragmentOrigin::Solved);
    let left = recording.bodies.iter().filter(|body| !broken.contains(&body.id));
    left.map(|body| {
        let h = body.parent.and_then(|parent| spacing.get(&parent)).copied().unwrap_or(0.0);
        MeasuredPart {
            object: body.object.clone(),
            broken: body.generation > 0,
            mass: body.mass,
            cell: h * h * h * body.mass / body.volume,
            sampled: !found(body.id),
        }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::{MeasuredPart, halves, mott, pooled};
    use crate::frontier::stats::mass_distance;

    /// Single seeds of wholes and halves are far from the mixture; together they are it.
    #[test]
    fn seeds_are_pooled_before_they_are_compared() {
        let seeds = vec![vec![1.0], vec![0.5, 0.5], vec![1.0], vec![0.5, 0.5]];
        let reference = seeds.concat();
        assert!(mass_distance(&seeds[0], &reference) > 0.3);
        let to = |masses: &[f64]| mass_distance(masses, &reference);
        let each = pooled(&seeds, &to);
        assert!(each.iter().sum::<f64>().abs() < 1e-12, "{each:?}");
        // The mean is the distance of the pool, whatever the seeds scatter.
        let other = vec![vec![1.0], vec![1.0], vec![0.25; 4]];
        let mean = pooled(&other, &to).iter().sum::<f64>() / 3.0;
        assert!((mean - mass_distance(&other.concat(), &reference)).abs() < 1e-12);
        assert_eq!(pooled(&other[..1], &to), [mass_distance(&other[0], &reference)]);
    }

    /// Masses at even quantiles of Mott's law are at it; crumbs, wholes and sampled pieces do not
    /// count.
    #[test]
    fn resolved_pieces_are_held_against_motts_law() {
        let part = |mass: f64, broken: bool| MeasuredPart {
            object: "ball".to_owned(),
            broken,
            mass,
            cell: 1e-6,
            sampled: false,
        };
        let law = |k: i32| (8e-3 - 0.02 * libm::log(1.0 - (f64::from(k) + 0.5) / 200.0)).powi(2);
        let mut parts: Vec<MeasuredPart> = (0..200).map(|k| part(law(k), true)).collect();
        let own = mott(&parts);
        assert!(own < 0.02, "{own}");
        parts.extend((0..100).map(|_| part(6.3e-5, true)));
        parts.extend((0..100).map(|_| part(1.0, false)));
        parts.extend((0..100).map(|_| MeasuredPart { sampled: true, ..part(2e-4, true) }));
        assert!((mott(&parts) - own).abs() < 1e-12);
        let even: Vec<MeasuredPart> =
            (0..50).map(|k| part(1e-3 + 1e-6 * f64::from(k), true)).collect();
        assert!(mott(&even) > 0.2 && mott(&even[..2]).is_nan(), "{}", mott(&even));
    }

    #[test]
    fn halves_of_an_ensemble_tell_what_chance_does() {
        let seeds = vec![vec![1.0], vec![1.0], vec![0.5, 0.5], vec![0.5, 0.5]];
        // Wholes against halves, then one of each against one of each.
        assert_eq!(halves(&seeds, 0), 1.0);
        assert_eq!(halves(&seeds, 1), 0.0);
        assert!(halves(&seeds[..1], 0).is_nan() && halves(&[], 0).is_nan());
    }
}
