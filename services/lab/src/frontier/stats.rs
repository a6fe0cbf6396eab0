//! What charts are read by: Pareto sets, costs to an error, extrapolation, ensembles.

/// Student's t for 95 % of both sides, from one degree of freedom on \[1\].
const STUDENT: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
    2.052, 2.048, 2.045, 2.042,
];

/// Least and greatest order that is believed \[1\].
pub const ORDERS: (f64, f64) = (0.5, 2.0);

/// Safety factor of the grid convergence index \[1\].
const SAFETY: f64 = 1.25;

/// How far above a target an error may lie and still be at it: rounding \[1\].
const SLACK: f64 = 1e-9;

/// Differences below this share of the values are rounding, not convergence \[1\].
const ROUNDING: f64 = 1e-12;

/// Which of the points (cost, error) are worth keeping: those that no other undercuts in one and
/// matches or undercuts in the other. In order of cost.
#[must_use]
pub fn pareto(points: &[(f64, f64)]) -> Vec<usize> {
    let beaten = |&(cost, error): &(f64, f64)| {
        points.iter().any(|&(c, e)| c <= cost && e <= error && (c < cost || e < error))
    };
    let mut kept: Vec<usize> = (0..points.len()).filter(|&k| !beaten(&points[k])).collect();
    kept.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0));
    kept
}

/// Whether an error is at or below a target.
fn within(error: f64, target: f64) -> bool {
    error <= target * (1.0 + SLACK)
}

/// The cost at which an error is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorCost {
    /// In the unit of the points' cost.
    pub cost: f64,
    /// Whether it may be less: the cheapest point of the curve is as true already.
    pub at_most: bool,
}

/// The cost from which on a curve stays at or below an error: where straight lines between its
/// points, in logarithms of both, cross it for the last time. A point is its cost and its error; a
/// failed run has no error, and nothing is put between it and its neighbours. Nothing if the
/// dearest point is above.
#[must_use]
pub fn cost_to(curve: &[(f64, Option<f64>)], target: f64) -> Option<ErrorCost> {
    let mut points = curve.to_vec();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let good = |error: Option<f64>| error.is_some_and(|error| within(error, target));
    let first = points.iter().rposition(|point| !good(point.1)).map_or(0, |last| last + 1);
    let cost = points.get(first)?.0;
    let Some(before) = first.checked_sub(1) else {
        return Some(ErrorCost { cost, at_most: true });
    };
    let (Some(high), Some(low)) = (points[before].1, points[first].1) else {
        return Some(ErrorCost { cost, at_most: false });
    };
    // An exact point lies infinitely low: the line to it falls at once.
    if low <= 0.0 || points[before].0 <= 0.0 {
        return Some(ErrorCost { cost, at_most: false });
    }
    let share = libm::log(high / target) / libm::log(high / low);
    let log = |k: usize| libm::log(points[k].0);
    let cost = libm::exp(log(before) + share * (log(first) - log(before)));
    Some(ErrorCost { cost, at_most: false })
}

/// The cheapest of the points (cost, error) that is as true as that; it is in the Pareto set.
#[must_use]
pub fn cheapest(points: &[(f64, f64)], target: f64) -> Option<usize> {
    pareto(points).into_iter().find(|&k| within(points[k].1, target))
}

/// How three refinements lie to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    /// They close in with an order that can be believed.
    Asymptotic,
    /// They close in faster or slower than any order that can be believed.
    Clamped,
    /// They go to and fro.
    Oscillating,
    /// The steps do not get smaller.
    Growing,
}

/// What three refinements say about the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Richardson {
    /// The order as it is seen; not a number where the values go to and fro \[1\].
    pub seen: f64,
    /// The order that is used, within [`ORDERS`] \[1\].
    pub order: f64,
    /// The limit.
    pub value: f64,
    /// Grid convergence index of the finest: a bound on its error over its size \[1\].
    pub index: f64,
    /// Whether any of it can be believed.
    pub trend: Trend,
}

/// Richardson's extrapolation of values at spacings r²h, rh and h, coarsest first, with r = `ratio`
/// above 1. With r = 2: p = log₂|(q₄ − q₂)/(q₂ − q₁)| within [`ORDERS`],
/// q* = q₁ + (q₁ − q₂)/(2ᵖ − 1), GCI = 1.25 |q₁ − q₂|/(2ᵖ − 1)/|q₁|.
#[must_use]
pub fn richardson(values: [f64; 3], ratio: f64) -> Richardson {
    let [coarse, middle, fine] = values;
    let size = values.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let (first, second) = (coarse - middle, middle - fine);
    let still = |step: f64| step.abs() <= ROUNDING * size;
    let seen = match (still(first), still(second)) {
        (_, true) => f64::INFINITY,
        (true, false) => f64::NEG_INFINITY,
        _ if first * second < 0.0 => f64::NAN,
        _ => libm::log(first / second) / libm::log(ratio),
    };
    let trend = if seen.is_nan() {
        Trend::Oscillating
    } else if seen <= 0.0 {
        Trend::Growing
    } else if seen < ORDERS.0 || seen > ORDERS.1 && !still(second) {
        Trend::Clamped
    } else {
        Trend::Asymptotic
    };
    let order = if seen.is_nan() { ORDERS.0 } else { seen.clamp(ORDERS.0, ORDERS.1) };
    let step = -second / (libm::pow(ratio, order) - 1.0);
    let index = if still(second) { 0.0 } else { SAFETY * (step / fine).abs() };
    Richardson { seen, order, value: fine + step, index, trend }
}

/// What several seeds say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ensemble {
    /// How many there are.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Half of the 95 % confidence band of the mean, by Student's t; nothing for one alone.
    pub half: Option<f64>,
}

/// The mean of an ensemble and how far it can be trusted (F78); nothing of nothing.
#[must_use]
pub fn ensemble(values: &[f64]) -> Option<Ensemble> {
    let count = values.len();
    let n = count as f64;
    if count == 0 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    if count == 1 {
        return Some(Ensemble { count, mean, half: None });
    }
    let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    let half = student(count - 1) * (square / n).sqrt();
    Some(Ensemble { count, mean, half: Some(half) })
}

/// Student's t for 95 % of both sides.
fn student(freedom: usize) -> f64 {
    let listed = freedom.checked_sub(1).and_then(|k| STUDENT.get(k));
    listed.copied().unwrap_or(1.96 + 2.46 / freedom as f64)
}

/// Wasserstein's distance of two distributions of mass over the size of its pieces, in shares of
/// the second one's mean: ∫|F − G| dm / ∫m dG, where F(m) is the share of the mass that lies in
/// pieces lighter than m. Of even pieces it is |m − m₀|/m₀. Not a number where a side has no mass.
#[must_use]
pub fn mass_distance(masses: &[f64], reference: &[f64]) -> f64 {
    let (whole, full) = (masses.iter().sum::<f64>(), reference.iter().sum::<f64>());
    if whole <= 0.0 || full <= 0.0 {
        return f64::NAN;
    }
    let mean = reference.iter().map(|m| m * m).sum::<f64>() / full;
    let share = |list: &[f64], total: f64, sign: f64| {
        list.iter().map(|&m| (m, sign * m / total)).collect::<Vec<_>>()
    };
    let mut steps = share(masses, whole, 1.0);
    steps.extend(share(reference, full, -1.0));
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut gap, mut area) = (0.0_f64, 0.0);
    for pair in steps.windows(2) {
        gap += pair[0].1;
        area += gap.abs() * (pair[1].0 - pair[0].0);
    }
    area / mean
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-12 * b.abs().max(1e-300), "{a} is not {b}");
    }

    #[test]
    fn the_pareto_set_is_what_nothing_undercuts() {
        let points = [(4.0, 0.1), (1.0, 0.5), (2.0, 0.6), (2.0, 0.2), (8.0, 0.1), (16.0, 0.01)];
        assert_eq!(pareto(&points), [1, 3, 0, 5]);
        // Twins do not undercut each other.
        assert_eq!(pareto(&[(1.0, 0.5), (1.0, 0.5), (2.0, 0.5)]), [0, 1]);
        assert_eq!(pareto(&[]), Vec::<usize>::new());
        assert_eq!(cheapest(&points, 0.25), Some(3));
        assert_eq!(cheapest(&points, 0.1), Some(0));
        assert_eq!(cheapest(&points, 0.001), None);
    }

    /// Error over cost with slope −½: 0.4 at 1, 0.2 at 4, 0.05 at 64.
    #[test]
    fn an_error_costs_what_the_line_between_points_says() {
        let curve = [(64.0, Some(0.05)), (1.0, Some(0.4)), (4.0, Some(0.2))];
        let reach = cost_to(&curve, 0.1).expect("it is reached");
        close(reach.cost, 16.0);
        assert!(!reach.at_most);
        close(cost_to(&curve, 0.2).expect("at a point").cost, 4.0);
        assert_eq!(cost_to(&curve, 0.04), None);
        assert_eq!(cost_to(&curve, 0.5), Some(ErrorCost { cost: 1.0, at_most: true }));
    }

    /// True by chance at 1, wrong at 4: only what stays true counts.
    #[test]
    fn a_point_that_is_true_by_chance_is_not_the_cost() {
        let curve = [(1.0, Some(0.01)), (4.0, Some(0.4)), (16.0, Some(0.1)), (64.0, Some(0.02))];
        close(cost_to(&curve, 0.2).expect("reached").cost, 8.0);
        let failed = [(1.0, Some(0.01)), (4.0, None), (16.0, Some(0.1))];
        assert_eq!(cost_to(&failed, 0.2), Some(ErrorCost { cost: 16.0, at_most: false }));
        assert_eq!(cost_to(&[(1.0, Some(0.01)), (4.0, None)], 0.2), None);
        assert_eq!(cost_to(&[], 0.2), None);
        let exact = [(1.0, Some(0.4)), (4.0, Some(0.0))];
        close(cost_to(&exact, 0.1).expect("reached").cost, 4.0);
    }

    /// q = 10 + h at h = 4, 2, 1: order 1, limit 10, index 1.25 · 1/11.
    #[test]
    fn the_limit_of_a_first_order_method_is_found() {
        let found = richardson([14.0, 12.0, 11.0], 2.0);
        close(found.order, 1.0);
        close(found.value, 10.0);
        close(found.index, 1.25 / 11.0);
        assert_eq!(found.trend, Trend::Asymptotic);
        // q = 10 + h², with ratio 3: 9², 3², 1.
        let found = richardson([91.0, 19.0, 11.0], 3.0);
        close(found.order, 2.0);
        close(found.value, 10.0);
    }

    #[test]
    fn what_is_not_in_the_asymptotic_range_is_told() {
        // Order 3 is not believed: 2 is used, 10 + 1/8 and a step of 7/8: q* = q₁ − (7/8)/3.
        let fast = richardson([74.0, 18.0, 11.0], 2.0);
        assert_eq!(fast.trend, Trend::Clamped);
        close(fast.seen, 3.0);
        close(fast.order, 2.0);
        close(fast.value, 11.0 - 7.0 / 3.0);
        // Steps 1.1, then 1: order 0.1375, of which 0.5 is made.
        let slow = richardson([12.1, 11.0, 10.0], 2.0);
        assert_eq!((slow.trend, slow.order), (Trend::Clamped, 0.5));
        close(slow.value, 10.0 - 1.0 / (2.0_f64.sqrt() - 1.0));
        assert_eq!(richardson([1.0, 2.0, 1.5], 2.0).trend, Trend::Oscillating);
        assert_eq!(richardson([4.0, 3.0, 1.0], 2.0).trend, Trend::Growing);
        assert_eq!(richardson([3.0, 3.0, 1.0], 2.0).trend, Trend::Growing);
        let still = richardson([3.0, 3.0, 3.0], 2.0);
        assert_eq!((still.value, still.index, still.trend), (3.0, 0.0, Trend::Asymptotic));
    }

    /// 1 to 8: mean 4.5, variance 6, t₇ = 2.365: half a band of 2.365 √(6/8).
    #[test]
    fn an_ensemble_knows_how_far_its_mean_can_be_trusted() {
        let eight: Vec<f64> = (1..=8).map(f64::from).collect();
        let found = ensemble(&eight).expect("eight");
        assert_eq!((found.count, found.mean), (8, 4.5));
        close(found.half.expect("a band"), 2.365 * 0.75_f64.sqrt());
        assert_eq!(ensemble(&[3.0]), Some(Ensemble { count: 1, mean: 3.0, half: None }));
        assert_eq!(ensemble(&[]), None);
        // Printed tables: t₄₀ = 2.021, t₁₂₀ = 1.980.
        assert!((student(40) - 2.021).abs() < 2e-3 && (student(120) - 1.980).abs() < 2e-3);
        assert_eq!((student(1), student(30)), (12.706, 2.042));
    }

    #[test]
    fn the_distance_of_masses_is_that_of_even_pieces() {
        // A whole against halves: |1 − ½|/½.
        close(mass_distance(&[1.0], &[0.5, 0.5]), 1.0);
        close(mass_distance(&[0.25; 4], &[0.5, 0.5]), 0.5);
        assert_eq!(mass_distance(&[0.5, 0.5], &[0.5, 0.5]), 0.0);
        // ¾ of the mass in a piece of 3, ¼ in one of 1, against a piece of 4: F is ¼ from 1 to 3
        // and 1 from 3 to 4, so 2 · ¼ + 1 = 1.5, of 4.
        close(mass_distance(&[1.0, 3.0], &[4.0]), 0.375);
        // How much there is in all is nobody's distance; nor is who comes first.
        assert_eq!(mass_distance(&[1.0; 4], &[1.0; 7]), 0.0);
        assert!(mass_distance(&[], &[1.0]).is_nan() && mass_distance(&[1.0], &[]).is_nan());
    }
}
