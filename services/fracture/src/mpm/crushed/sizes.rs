//! Of what volumes sampled pieces are, and that their cells have them.

use super::rules::STREAM;
use cullet_fragment::pieces::Ball;
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Greatest least volume over the mean that leaves sizes to choose among \[1\].
const LEAST_SHARE: f64 = 0.8;

/// Pieces that a place may end in: those nearest to it at first.
const NEAR: usize = 24;

/// Buckets of mean pieces to each side in which they are looked for.
const REACH: i32 = 3;

/// Rounds in which cells are brought to their volumes ...
const ROUNDS: usize = 40;

/// ... and the share of what is missing that is made up for in each.
const STEP: f64 = 0.5;

/// Mott's law, N(>m) = N₀ exp(−√(m/μ)), between two masses: x = √(m/μ) is exponential from the
/// least to the greatest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mott {
    /// √(m/μ) of the least mass ...
    start: f64,
    /// ... and what it has more at the greatest.
    span: f64,
    /// m/μ in the mean, were there no greatest.
    mean: f64,
}

impl Mott {
    /// The law from `least` to `most`, over the mean that it would have without a greatest mass.
    pub(super) fn new(least: f64, most: f64) -> Self {
        // x − x₀ is exponential, and the mean of m is μ (x₀² + 2x₀ + 2).
        let excess = 1.0 / least.min(LEAST_SHARE) - 1.0;
        let start = if least > 0.0 { (1.0 + (1.0 + 2.0 * excess).sqrt()) / excess } else { 0.0 };
        let mean = start * start + 2.0 * start + 2.0;
        let span = ((most * mean).sqrt() - start).max(f64::MIN_POSITIVE);
        Self { start, span, mean }
    }

    /// The mean, over what it would be without a greatest mass.
    pub(super) fn mean(&self) -> f64 {
        let beyond = |x: f64| x * x + 2.0 * x + 2.0;
        let tail = libm::exp(-self.span);
        if tail == 0.0 {
            return 1.0;
        }
        let kept = beyond(self.start) - tail * beyond(self.start + self.span);
        kept / ((1.0 - tail) * self.mean)
    }

    /// Volumes, over the mean without a greatest one, the largest first: one of each of as many
    /// parts of the law that are alike likely, so that a few pieces already have its whole range.
    pub(super) fn volumes(&self, count: usize, seed: u64) -> Vec<f64> {
        let within = 1.0 - libm::exp(-self.span);
        let volume = |k: usize| {
            let share = (k as f64 + unit(seed, STREAM + 3, k as u64)) / count as f64;
            let root = self.start - libm::log(1.0 - within * share);
            root * root / self.mean
        };
        (0..count).rev().map(volume).collect()
    }
}

/// Brings the cells of balls to the volumes that are `wanted`, in proportion, by their weights
/// (Bourne, Kok, Roper and Spanjer, Laguerre tessellations and polycrystalline microstructures,
/// 2020). `samples`: places that are to be divided, and the volume of each.
pub(super) fn balance(balls: &mut [Ball], wanted: &[f64], samples: &[(Vec3, f64)]) {
    let whole: f64 = samples.iter().map(|sample| sample.1).sum();
    let scale = whole / wanted.iter().sum::<f64>();
    if balls.len() < 2 || !scale.is_finite() {
        return;
    }
    let near = near(balls, samples, libm::cbrt(whole / balls.len() as f64));
    for _ in 0..ROUNDS {
        let far = |k: u32, x: &Vec3| balls[k as usize].far(x);
        let owner = |((x, _), near): (&(Vec3, f64), &Vec<u32>)| {
            near.iter().copied().min_by(|&a, &b| far(a, x).total_cmp(&far(b, x)).then(a.cmp(&b)))
        };
        let owners: Vec<Option<u32>> = samples.par_iter().zip(&near).map(owner).collect();
        let mut volumes = vec![0.0; balls.len()];
        for (owner, (_, volume)) in owners.iter().zip(samples) {
            if let Some(owner) = owner {
                volumes[*owner as usize] += volume;
            }
        }
        for ((ball, wanted), volume) in balls.iter_mut().zip(wanted).zip(&volumes) {
            // A cube of side s among its like gains 3s of volume for each of weight.
            let (wanted, side) = (wanted * scale, libm::cbrt(wanted * scale));
            ball.weight += STEP * (wanted - volume) / (3.0 * side);
        }
    }
}

/// The balls nearest to each sample.
fn near(balls: &[Ball], samples: &[(Vec3, f64)], width: f64) -> Vec<Vec<u32>> {
    let bucket = |x: &Vec3| -> [i32; 3] { [0, 1, 2].map(|k| (x[k] / width).floor() as i32) };
    let mut buckets: BTreeMap<[i32; 3], Vec<u32>> = BTreeMap::new();
    for (ball, k) in balls.iter().zip(0..) {
        buckets.entry(bucket(&ball.place)).or_default().push(k);
    }
    let of = |(x, _): &(Vec3, f64)| {
        let [i, j, k] = bucket(x);
        let mut found: Vec<(f64, u32)> = Vec::new();
        for x_bucket in i - REACH..=i + REACH {
            for y_bucket in j - REACH..=j + REACH {
                let row = [x_bucket, y_bucket, k - REACH]..=[x_bucket, y_bucket, k + REACH];
                let balls_there = buckets.range(row).flat_map(|entry| entry.1);
                found.extend(balls_there.map(|&ball| (balls[ball as usize].far(x), ball)));
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(NEAR);
        found.into_iter().map(|entry| entry.1).collect()
    };
    samples.par_iter().map(of).collect()
}
