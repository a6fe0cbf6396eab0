//! What the rows of a chart say: its points, what is worth keeping, what an error costs.

use super::row::FrontierRow;
use super::set::{FINEST, FrontierChart};
use super::stats::{
    Ensemble, ErrorCost, Richardson, Trend, cheapest, cost_to, ensemble, pareto, richardson,
};
use std::fmt::Write;

/// Errors whose cost is reported \[1\].
pub const TARGETS: [f64; 2] = [0.1, 0.03];

/// Least cost: a tick of the clock that counts processor time \[s\].
const TICK: f64 = 0.01;

/// How far ratios of spacings may differ and still be one \[1\].
const EVEN: f64 = 0.03;

/// A point of a chart: one setting, with all its seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartPoint {
    /// Its curve.
    pub curve: usize,
    /// Where on it.
    pub along: String,
    /// Whether it is the default.
    pub standard: bool,
    /// Processor time of a run, in the mean \[s\].
    pub cost: f64,
    /// Spacing and time step, to tell how much finer it is \[m\], \[s\].
    pub fine: [f64; 2],
    /// What the seeds came to.
    pub value: Option<Ensemble>,
    /// Size of the mean's error, and the ends of its band \[1\]; nothing of a failed point.
    pub error: Option<(f64, f64, f64)>,
    /// Why it has none.
    pub failed: Option<String>,
}

/// What the finest points of a curve say about its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// By Richardson.
    pub estimate: Richardson,
    /// Whether the last step is within the confidence bands: then it says nothing.
    pub lost: bool,
}

/// A chart with all that is to be read off it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Names of the curves.
    pub curves: Vec<String>,
    /// Its points, a curve after the other.
    pub spots: Vec<ChartPoint>,
    /// Which of them nothing undercuts, in order of cost.
    pub pareto: Vec<usize>,
    /// What [`TARGETS`] cost along each curve.
    pub costs: Vec<[Option<ErrorCost>; 2]>,
    /// The cheapest points within [`TARGETS`].
    pub cheapest: [Option<usize>; 2],
    /// What the three finest spacings of each curve say.
    pub limits: Vec<Option<Limit>>,
    /// How many seeds a point has.
    pub seeds: usize,
}

/// Reads a chart off the rows that are its own.
#[must_use]
pub fn read(chart: &FrontierChart, rows: &[FrontierRow]) -> Reading {
    // With one seed there is nothing to hold the finest run against.
    let alone =
        |row: &FrontierRow| row.option == FINEST && row.status == "ok" && row.value.is_none();
    let own = || rows.iter().filter(|row| row.chart == chart.name && !alone(row));
    let mut curves: Vec<String> = Vec::new();
    let mut groups: Vec<(usize, &str, Vec<&FrontierRow>)> = Vec::new();
    for row in own() {
        let known = curves.iter().position(|name| *name == row.option);
        let curve = known.unwrap_or(curves.len());
        if known.is_none() {
            curves.push(row.option.clone());
        }
        match groups.iter_mut().find(|group| group.0 == curve && group.1 == row.along) {
            Some(group) => group.2.push(row),
            None => groups.push((curve, &row.along, vec![row])),
        }
    }
    let spots: Vec<ChartPoint> =
        groups.iter().map(|(curve, _, rows)| spot(chart, *curve, rows)).collect();
    // What a curve is compared with is no way to solve anything, and what shows another number
    // undercuts nothing.
    let other = |name: &str| own().any(|row| row.option == name && row.metric != chart.metric);
    let rivals: Vec<bool> = curves.iter().map(|name| name != FINEST && !other(name)).collect();
    let judged: Vec<usize> =
        (0..spots.len()).filter(|&k| spots[k].error.is_some() && rivals[spots[k].curve]).collect();
    let plane: Vec<(f64, f64)> =
        judged.iter().filter_map(|&k| Some((spots[k].cost, spots[k].error?.0))).collect();
    let of = |curve: usize| spots.iter().filter(move |spot| spot.curve == curve);
    let price = |curve: usize| -> [Option<ErrorCost>; 2] {
        let points: Vec<_> = of(curve).map(|s| (s.cost, s.error.map(|error| error.0))).collect();
        TARGETS.map(|target| cost_to(&points, target))
    };
    Reading {
        pareto: pareto(&plane).into_iter().map(|k| judged[k]).collect(),
        costs: (0..curves.len()).map(price).collect(),
        cheapest: TARGETS.map(|target| cheapest(&plane, target).map(|k| judged[k])),
        limits: (0..curves.len()).map(|curve| limit(&of(curve).collect::<Vec<_>>())).collect(),
        seeds: groups.iter().map(|group| group.2.len()).max().unwrap_or(0),
        curves,
        spots,
    }
}

fn spot(chart: &FrontierChart, curve: usize, rows: &[&FrontierRow]) -> ChartPoint {
    let n = rows.len() as f64;
    let bad: Vec<&str> = rows
        .iter()
        .filter(|row| row.status != "ok" || row.value.is_none())
        .map(|row| if row.status == "ok" { "no value" } else { row.status.as_str() })
        .collect();
    let failed = bad.first().map(|word| match rows.len() {
        1 => (*word).to_owned(),
        all => format!("{word}, {} of {all} seeds", bad.len()),
    });
    let values: Vec<f64> = rows.iter().filter_map(|row| row.value).collect();
    let value = ensemble(&values).filter(|_| failed.is_none());
    let error = value.map(|value| {
        let size = (value.mean - chart.reference).abs() / chart.scale;
        let half = value.half.unwrap_or(0.0) / chart.scale;
        (size, (size - half).max(0.0), size + half)
    });
    let (first, cost) = (rows.first(), rows.iter().map(|row| row.cpu).sum::<f64>() / n);
    ChartPoint {
        curve,
        along: first.map(|row| row.along.clone()).unwrap_or_default(),
        standard: rows.iter().any(|row| row.standard),
        cost: cost.max(TICK),
        fine: first.map_or([0.0; 2], |row| [row.spacing, row.step]),
        value,
        error,
        failed,
    }
}

/// Richardson's estimate of the three finest points of a curve that lie at one ratio.
fn limit(curve: &[&ChartPoint]) -> Option<Limit> {
    [0, 1].into_iter().find_map(|by| {
        let mut points: Vec<(f64, Ensemble)> =
            curve.iter().filter_map(|s| Some((s.fine[by], s.value?))).collect();
        points.retain(|point| point.0 > 0.0);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| (a.0 / b.0 - 1.0).abs() < EVEN);
        for (k, fine) in points.iter().enumerate() {
            for (m, middle) in points.iter().enumerate().skip(k + 1) {
                let ratio = middle.0 / fine.0;
                let even = |c: &&(f64, Ensemble)| (c.0 / middle.0 / ratio - 1.0).abs() < EVEN;
                if let Some(coarse) = points[m..].iter().find(even) {
                    return Some(extrapolated([coarse, middle, fine]));
                }
            }
        }
        None
    })
}

fn extrapolated([coarse, middle, fine]: [&(f64, Ensemble); 3]) -> Limit {
    let values = [coarse, middle, fine].map(|point| point.1.mean);
    let half = |point: &(f64, Ensemble)| point.1.half.unwrap_or(0.0);
    let lost = (values[1] - values[2]).abs() < half(middle) + half(fine);
    Limit { estimate: richardson(values, (coarse.0 / fine.0).sqrt()), lost }
}

/// A number with three digits.
#[must_use]
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return if size == 0.0 { "0".to_owned() } else { "-".to_owned() };
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = (2.0 - libm::log10(size).floor()).clamp(0.0, 6.0);
    format!("{value:.0$}", digits as usize)
}

/// A share as per cent, with two digits.
#[must_use]
pub fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return if size == 0.0 { "0 %".to_owned() } else { "-".to_owned() };
    }
    if size < 1e-3 {
        return format!("{value:.1e} %");
    }
    let digits = (1.0 - libm::log10(size).floor()).clamp(0.0, 5.0);
    let text = format!("{value:.0$}", digits as usize);
    format!("{} %", text.strip_suffix(".0").unwrap_or(&text))
}

/// A place on a curve as people read it: without the last digits of a long number.
#[must_use]
pub fn shown(along: &str) -> String {
    let long = along.split_once('=').filter(|(_, value)| value.len() > 8);
    match long.and_then(|(key, value)| Some((key, value.parse::<f64>().ok()?))) {
        Some((key, value)) => format!("{key}={}", short(value)),
        None => along.to_owned(),
    }
}

/// What an error costs along a curve, in words.
#[must_use]
pub fn told(reach: Option<ErrorCost>) -> String {
    match reach {
        None => "not reached".to_owned(),
        Some(ErrorCost { cost, at_most: true }) => format!("<= {} s", short(cost)),
        Some(ErrorCost { cost, .. }) => format!("{} s", short(cost)),
    }
}

/// A chart as a table, and what is read off it.
#[must_use]
pub fn text(chart: &FrontierChart, reading: &Reading) -> String {
    let mut text =
        format!("{}: {}\n  {}\n", chart.name, chart.title, measure(chart, reading.seeds));
    let head = ["", "option", "along", "cost", "value", "error", "band", ""].map(str::to_owned);
    let mut lines = vec![head];
    for (k, spot) in reading.spots.iter().enumerate() {
        let kept = reading.pareto.contains(&k);
        let mark =
            format!("{}{}", if spot.standard { "*" } else { "" }, if kept { "P" } else { "" });
        let band = spot.error.filter(|_| spot.value.is_some_and(|v| v.half.is_some()));
        lines.push([
            mark,
            reading.curves[spot.curve].clone(),
            shown(&spot.along),
            format!("{} s", short(spot.cost)),
            spot.value.map(|value| short(value.mean)).unwrap_or_default(),
            spot.error.map(|error| percent(error.0)).unwrap_or_default(),
            band.map(|(_, low, high)| format!("{} to {}", percent(low), percent(high)))
                .unwrap_or_default(),
            spot.failed.clone().unwrap_or_default(),
        ]);
    }
    text.push_str(&aligned(&lines));
    for (k, target) in TARGETS.iter().enumerate() {
        let best = reading.cheapest[k].map(|index| &reading.spots[index]);
        let best = best.map_or("no point".to_owned(), |spot| {
            let name = &reading.curves[spot.curve];
            let doubt = doubt(spot, *target);
            format!("{name} at {}, {} s{doubt}", shown(&spot.along), short(spot.cost))
        });
        let each = |(name, costs): (&String, &[Option<ErrorCost>; 2])| {
            format!("{name} {}", told(costs[k]))
        };
        let curves = reading.curves.iter().zip(&reading.costs).filter(|(name, _)| *name != FINEST);
        let curves: Vec<String> = curves.map(each).collect();
        let line = format!("  to {}: {best}; along curves: ", percent(*target));
        let _never = writeln!(text, "{line}{}", curves.join(", "));
    }
    for (name, limit) in reading.curves.iter().zip(&reading.limits) {
        if let Some(limit) = limit {
            let _never = writeln!(text, "  {name}: {}", converges(limit));
        }
    }
    text
}

/// A word of doubt, where the band of a point's mean goes beyond an error that it is within.
#[must_use]
pub fn doubt(spot: &ChartPoint, target: f64) -> String {
    let beyond = spot.error.filter(|(size, _, high)| high > size && *high > target);
    beyond.map(|(_, _, high)| format!(" (band to {})", percent(high))).unwrap_or_default()
}

/// What three refinements say, in words.
fn converges(limit: &Limit) -> String {
    if limit.lost {
        return "the last refinement is within the scatter of seeds".to_owned();
    }
    let Richardson { seen, order, value, index, trend } = &limit.estimate;
    let (seen, value, index) = (short(*seen), short(*value), percent(*index));
    match trend {
        Trend::Asymptotic => format!("order {order:.2}, limit {value}, GCI {index}"),
        Trend::Clamped => {
            format!("not asymptotic: order {seen}; with {order:.1} limit {value}, GCI {index}")
        }
        Trend::Oscillating => "not asymptotic: goes to and fro; ask an ensemble".to_owned(),
        Trend::Growing => "not asymptotic: steps do not get smaller".to_owned(),
    }
}

/// What is measured, in a line.
#[must_use]
pub fn measure(chart: &FrontierChart, seeds: usize) -> String {
    let source = if chart.source.is_empty() { "" } else { ": " };
    let mut text = if chart.reference == 0.0 {
        chart.metric.clone()
    } else {
        format!("{} against {}", chart.metric, chart.reference)
    };
    if chart.scale != chart.reference.abs() && chart.scale != 1.0 {
        let _never = write!(text, ", over {}", chart.scale);
    }
    let _never = write!(text, "{source}{}", chart.source);
    if seeds > 1 {
        let _never = write!(text, "; mean of {seeds} seeds with its 95 % band");
    }
    text
}

fn aligned(lines: &[[String; 8]]) -> String {
    let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..8).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let cells = line.iter().zip(&widths).enumerate().map(|(k, (cell, &width))| {
            let number = matches!(k, 3..=5);
            if number { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        let line = cells.collect::<Vec<_>>().join("  ");
        text.push_str(&format!("  {}\n", line.trim_end()));
    }
    text
}
