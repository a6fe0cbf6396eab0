//! Numbers made of samples, and compared with what is expected.

use super::format::{Expected, Metric, Reduction};
use cullet_document::check::tell;

/// The number that a metric makes of the samples of its probe; not a number where there are too few
/// of them for it, where what it asks for never happens, or where a sample it looks at is none.
#[must_use]
pub fn reduce(metric: &Metric, times: &[f64], values: &[f64]) -> f64 {
    let (from, until) =
        (metric.from.unwrap_or(f64::NEG_INFINITY), metric.until.unwrap_or(f64::INFINITY));
    // The ends of a window are meant to be in it, whatever their last bits.
    let slack = 1e-9 * times.last().copied().unwrap_or(0.0);
    let inside = |t: f64| t >= from - slack && t <= until + slack;
    let rows: Vec<(f64, f64)> = times
        .iter()
        .copied()
        .zip(values.iter().map(|value| value + metric.offset))
        .filter(|(time, _)| inside(*time))
        .collect();
    let number = number(metric, &rows);
    metric.scale * number
}

fn number(metric: &Metric, rows: &[(f64, f64)]) -> f64 {
    let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else {
        return f64::NAN;
    };
    let one = matches!(metric.reduce, Reduction::First | Reduction::Final | Reduction::At);
    if !one && rows.iter().any(|row| row.1.is_nan()) {
        return f64::NAN;
    }
    let greatest = || rows.iter().fold(first, |m, &r| if r.1 > m.1 { r } else { m });
    let least = || rows.iter().fold(first, |m, &r| if r.1 < m.1 { r } else { m });
    let size = || rows.iter().map(|r| r.1.abs()).fold(0.0, f64::max);
    let integral =
        || -> f64 { rows.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum() };
    match metric.reduce {
        Reduction::First => first.1,
        Reduction::Final => last.1,
        Reduction::Max => greatest().1,
        Reduction::Min => least().1,
        Reduction::MaxSize => size(),
        Reduction::Range => greatest().1 - least().1,
        Reduction::Mean => integral() / (last.0 - first.0),
        Reduction::Integral => integral(),
        Reduction::At => at(rows, metric.time.unwrap_or(0.0)),
        Reduction::TimeOfMax => greatest().0,
        Reduction::TimeOfMin => least().0,
        Reduction::TimeReached => reached(rows, metric.threshold.unwrap_or(0.0)),
        Reduction::TimeAbove => above(rows, metric.threshold.unwrap_or(0.0)),
        Reduction::Slope => slope(rows),
        Reduction::MaxSlope => {
            let steep = slopes(rows, metric.window.unwrap_or(0.0)).flatten();
            steep.fold(f64::NAN, f64::max)
        }
        Reduction::Period => period(rows),
        Reduction::Decrement => decrement(rows),
        Reduction::Exponent => exponent(rows),
        Reduction::Drift => (last.1 - first.1) / size(),
    }
}

fn between(a: (f64, f64), b: (f64, f64), time: f64) -> f64 {
    if b.0 > a.0 { a.1 + (b.1 - a.1) * (time - a.0) / (b.0 - a.0) } else { b.1 }
}

fn at(rows: &[(f64, f64)], time: f64) -> f64 {
    let slack = 1e-9 * rows.last().map_or(0.0, |row| row.0.abs());
    let found = rows.windows(2).find(|w| w[0].0 - slack <= time && time <= w[1].0 + slack);
    found.map_or(f64::NAN, |w| between(w[0], w[1], time))
}

/// The moment at which a straight line between two samples has a value.
fn crossing(a: (f64, f64), b: (f64, f64), value: f64) -> f64 {
    a.0 + (b.0 - a.0) * (value - a.1) / (b.1 - a.1)
}

fn reached(rows: &[(f64, f64)], value: f64) -> f64 {
    if rows[0].1 >= value {
        return rows[0].0;
    }
    let found = rows.windows(2).find(|w| w[0].1 < value && w[1].1 >= value);
    found.map_or(f64::NAN, |w| crossing(w[0], w[1], value))
}

fn above(rows: &[(f64, f64)], value: f64) -> f64 {
    let part = |w: &[(f64, f64)]| {
        let (a, b) = (w[0], w[1]);
        match (a.1 >= value, b.1 >= value) {
            (true, true) => b.0 - a.0,
            (true, false) => crossing(a, b, value) - a.0,
            (false, true) => b.0 - crossing(a, b, value),
            (false, false) => 0.0,
        }
    };
    rows.windows(2).map(part).sum()
}

fn slope(rows: &[(f64, f64)]) -> f64 {
    let n = rows.len() as f64;
    let (t, v) = rows.iter().fold((0.0, 0.0), |s, r| (s.0 + r.0 / n, s.1 + r.1 / n));
    let sum = |f: fn(f64, f64) -> f64| rows.iter().map(|r| f(r.0 - t, r.1 - v)).sum::<f64>();
    sum(|t, v| t * v) / sum(|t, _| t * t)
}

/// The slope at each sample, by the straight line of least squares through those of the last
/// `window` \[s\]; none until one has gone by.
fn slopes(rows: &[(f64, f64)], window: f64) -> impl Iterator<Item = Option<f64>> {
    (0..rows.len()).map(move |last| {
        let first = rows.partition_point(|row| row.0 < rows[last].0 - window * (1.0 + 1e-9));
        let long = last > first && rows[last].0 - rows[first].0 > 0.9 * window;
        long.then(|| slope(&rows[first..=last]))
    })
}

/// The speed at each sample, of the places of the last `window` \[s\]; 0 until one has gone by.
#[must_use]
pub fn speeds(times: &[f64], places: &[f64], window: f64) -> Vec<f64> {
    let rows: Vec<(f64, f64)> = times.iter().copied().zip(places.iter().copied()).collect();
    slopes(&rows, window).map(|speed| speed.unwrap_or(0.0)).collect()
}

/// The slope in logarithms; none where there is none of a time or a value.
fn exponent(rows: &[(f64, f64)]) -> f64 {
    let inside = rows.iter().all(|row| row.0 > 0.0 && row.1 > 0.0);
    let logs = || rows.iter().map(|row| (libm::log(row.0), libm::log(row.1))).collect::<Vec<_>>();
    if inside { slope(&logs()) } else { f64::NAN }
}

/// Moments at which the samples cross their mean.
fn crossings(rows: &[(f64, f64)]) -> Vec<f64> {
    let mean = rows.iter().map(|row| row.1).sum::<f64>() / rows.len() as f64;
    rows.windows(2)
        .filter(|w| (w[0].1 < mean) != (w[1].1 < mean))
        .map(|w| crossing(w[0], w[1], mean))
        .collect()
}

fn period(rows: &[(f64, f64)]) -> f64 {
    let times = crossings(rows);
    let Some(pairs) = times.len().checked_sub(1).filter(|&pairs| pairs >= 2) else {
        return f64::NAN;
    };
    // Whole periods only, so that an uneven mean does no harm.
    let whole = pairs - pairs % 2;
    2.0 * (times[whole] - times[0]) / whole as f64
}

fn decrement(rows: &[(f64, f64)]) -> f64 {
    let mean = rows.iter().map(|row| row.1).sum::<f64>() / rows.len() as f64;
    let times = crossings(rows);
    // The top between two crossings, by the parabola through its three highest samples.
    let top = |w: &[f64]| {
        let inside: Vec<usize> =
            (0..rows.len()).filter(|&k| rows[k].0 >= w[0] && rows[k].0 <= w[1]).collect();
        let size = |k: usize| (rows[k].1 - mean).abs();
        let best = inside.into_iter().max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        if best == 0 || best + 1 == rows.len() {
            return Some(size(best));
        }
        let (a, b, c) = (size(best - 1), size(best), size(best + 1));
        let bend = a - 2.0 * b + c;
        Some(if bend < 0.0 { b - (c - a) * (c - a) / (8.0 * bend) } else { b })
    };
    let tops: Vec<f64> = times.windows(2).filter_map(top).collect();
    match (tops.first(), tops.last()) {
        // Two tops a period.
        (Some(first), Some(last)) if tops.len() > 2 => {
            2.0 * libm::log(first / last) / (tops.len() - 1) as f64
        }
        _ => f64::NAN,
    }
}

/// Whether a metric meets what is expected of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetricVerdict {
    /// Nothing is expected of it.
    Free,
    /// It holds.
    Holds,
    /// It does not.
    Fails,
    /// It does not, as is known.
    Gap,
}

/// A metric compared with what is expected of it.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricCheck {
    /// The reference, if there is one.
    pub reference: Option<f64>,
    /// Relative error; absolute where the reference is 0; nothing without one.
    pub error: Option<f64>,
    /// Whether it holds.
    pub verdict: MetricVerdict,
    /// What was asked for, in words.
    pub asked: String,
}

/// Holds a number against what is expected of it.
#[must_use]
pub fn weigh(expected: Option<&Expected>, value: f64) -> MetricCheck {
    let Some(expected) = expected else {
        let asked = String::new();
        return MetricCheck { reference: None, error: None, verdict: MetricVerdict::Free, asked };
    };
    let error = expected
        .value
        .map(|wanted| if wanted == 0.0 { value } else { (value - wanted) / wanted.abs() });
    let mut holds = !value.is_nan();
    let mut asked = Vec::new();
    if let (Some(wanted), Some(most)) = (expected.value, expected.tolerance) {
        holds &= (value - wanted).abs() <= most * wanted.abs();
        // Twelve digits: what a factor of a hundred does to the last ones is left out.
        let percent: f64 = format!("{:.11e}", 100.0 * most).parse().unwrap_or(100.0 * most);
        asked.push(format!("±{} %", tell(percent)));
    }
    if let (Some(wanted), Some(most)) = (expected.value, expected.absolute) {
        holds &= (value - wanted).abs() <= most;
        asked.push(format!("±{}", tell(most)));
    }
    if let Some(least) = expected.min {
        holds &= value >= least;
        asked.push(format!("≥ {}", tell(least)));
    }
    if let Some(most) = expected.max {
        holds &= value <= most;
        asked.push(format!("≤ {}", tell(most)));
    }
    let verdict = match (holds, &expected.gap) {
        (true, _) => MetricVerdict::Holds,
        (false, Some(_)) => MetricVerdict::Gap,
        (false, None) => MetricVerdict::Fails,
    };
    MetricCheck { reference: expected.value, error, verdict, asked: asked.join(", ") }
}
