//! The pieces that a solve leaves: those it found, and those sampled where it cannot tell.

use cullet_geometry::math::{scramble, unit};
use cullet_geometry::{Mat3, Vec3};
use cullet_model::{FragmentOrigin, Tolerance};
use std::f64::consts::TAU;

/// Waves that bend the borders of sampled pieces.
const WAVES: u64 = 8;
/// The shortest of them and the longest \[cells\].
const LENGTHS: [f64; 2] = [1.2, 6.0];
/// Their height over their length: together they turn a border by a third of a radian or so, and
/// no piece gets holes.
const STEEPNESS: f64 = 0.025;
/// Secants on the way to where an edge crosses a border.
const CHORDS: usize = 4;
/// Least slope of the difference of two powers that is gone by, over the distance of the balls
/// \[1\]; between round ones it is 2.
const LEAST_RISE: f64 = 0.3;
/// Stream of the seed's numbers.
const STREAM: u64 = 0x0b3d;

/// The pieces of a broken body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pieces {
    /// The piece of each point by id; `None` where a crack ran, to be shared between its sides.
    pub of: Vec<Option<u32>>,
    /// How many were found; sampled ones are numbered from here on.
    pub found: u32,
    /// Those that were sampled.
    pub rubble: Rubble,
    /// Share of the body in crushed zones \[1\].
    pub crushed: f64,
    /// How true they have to be.
    pub tolerance: Tolerance,
}

impl Pieces {
    /// The number among sampled pieces of one that was sampled.
    #[must_use]
    pub fn drawn(&self, piece: u32) -> Option<u32> {
        piece.checked_sub(self.found)
    }

    /// Where the parts of a cut come from: those are sampled most of whose points lie in sampled
    /// pieces. `part_of`: the part of each point by id.
    #[must_use]
    pub fn origins(&self, part_of: &[u32], parts: usize) -> Vec<FragmentOrigin> {
        let mut votes = vec![0_i64; parts];
        for (&part, piece) in part_of.iter().zip(&self.of) {
            if let (Some(vote), Some(piece)) = (votes.get_mut(part as usize), piece) {
                *vote += if self.drawn(*piece).is_some() { 1 } else { -1 };
            }
        }
        votes.into_iter().map(|vote| FragmentOrigin::of_sampled(vote > 0)).collect()
    }
}

/// Pieces sampled at random: cells of the power diagram of balls, some of them flattened or
/// stretched (Alpers et al., Generalized balanced power diagrams for 3D representations of
/// polycrystals, 2015), with bent borders. All places are in cells: metres over the size of a cell
/// along each axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rubble {
    /// A ball for each.
    pub balls: Vec<Ball>,
    waves: Vec<Wave>,
}

/// A ball of rubble.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its middle \[cells\].
    pub place: Vec3,
    /// Its diameter \[cells\], were it round.
    pub size: f64,
    /// Squares of distances from its middle: symmetric, of determinant one.
    pub form: Mat3,
    /// By how much its piece reaches farther than those of others \[cells²\]: (size/2)², until
    /// pieces are brought to their volumes.
    pub weight: f64,
}

impl Ball {
    /// A round one.
    #[must_use]
    pub fn round(place: Vec3, size: f64) -> Self {
        Self { place, size, form: Mat3::identity(), weight: 0.25 * size * size }
    }

    /// One that is `longer` times as long along a unit vector as a round one of that size, and
    /// thinner across; less than 1 makes a plate.
    #[must_use]
    pub fn drawn_out(place: Vec3, size: f64, along: &Vec3, longer: f64) -> Self {
        let form = Mat3::identity() * longer
            + along * along.transpose() * (1.0 / (longer * longer) - longer);
        Self { form, ..Self::round(place, size) }
    }

    /// Power of a place \[cells²\]: of equal round ones borders are plane, farther from the larger.
    #[must_use]
    pub fn far(&self, x: &Vec3) -> f64 {
        let arm = x - self.place;
        arm.dot(&(self.form * arm)) - self.weight
    }
}

/// A plane wave of displacements.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    number: Vec3,
    phase: f64,
    height: Vec3,
}

/// A direction, all alike likely (Archimedes).
pub fn direction(seed: u64, index: u64) -> Vec3 {
    let (sin, cos) = libm::sincos(TAU * unit(seed, 0, index));
    let z = 2.0 * unit(seed, 1, index) - 1.0;
    let flat = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(flat * cos, flat * sin, z)
}

impl Rubble {
    /// Balls whose borders are bent as the seed says.
    #[must_use]
    pub fn new(balls: Vec<Ball>, seed: u64) -> Self {
        let seed = scramble(seed ^ STREAM);
        let [short, long] = LENGTHS;
        let wave = |k: u64| {
            let length = short * libm::pow(long / short, k as f64 / (WAVES - 1) as f64);
            Wave {
                number: direction(seed, 2 * k) * (TAU / length),
                phase: TAU * unit(seed, 2, k),
                height: direction(seed, 2 * k + 1) * (STEEPNESS * length),
            }
        };
        Self { balls, waves: (0..WAVES).map(wave).collect() }
    }

    /// Where a place is as the plane borders see it.
    #[must_use]
    pub fn bent(&self, x: &Vec3) -> Vec3 {
        let shift = |w: &Wave| w.height * libm::sin(w.number.dot(x) + w.phase);
        x + self.waves.iter().map(shift).sum::<Vec3>()
    }

    /// In which of some pieces a place is.
    #[must_use]
    pub fn nearest(&self, of: impl IntoIterator<Item = u32>, x: &Vec3) -> Option<u32> {
        let x = self.bent(x);
        let far = |k: u32| self.balls[k as usize].far(&x);
        of.into_iter().min_by(|&a, &b| far(a).total_cmp(&far(b)).then(a.cmp(&b)))
    }

    /// The way from one piece to another across their border near a place, as a unit vector, and
    /// how far about \[cells\] the place is beyond the border.
    #[must_use]
    pub fn beyond(&self, one: u32, two: u32, x: &Vec3) -> (Vec3, f64) {
        let [one, two] = [one, two].map(|k| &self.balls[k as usize]);
        let x = self.bent(x);
        let slope = |ball: &Ball| ball.form * (x - ball.place) * 2.0;
        let steep = slope(one) - slope(two);
        let (rise, least) = (steep.norm(), LEAST_RISE * (two.place - one.place).norm());
        // In the middle between the sheets of a curved border there is no way to either.
        let way = if rise > least { steep / rise } else { (two.place - one.place).normalize() };
        (way, (one.far(&x) - two.far(&x)) / rise.max(least))
    }

    /// Where on the way from a place in one piece to a place in another their border is crossed
    /// \[1\].
    #[must_use]
    pub fn crossing(&self, one: u32, two: u32, from: &Vec3, to: &Vec3) -> f64 {
        let beyond = |share: f64| self.beyond(one, two, &(from + share * (to - from))).1;
        let (mut low, mut high) = ((0.0, beyond(0.0)), (1.0, beyond(1.0)));
        if low.1 >= 0.0 || high.1 <= 0.0 {
            return if low.1 >= 0.0 { 0.0 } else { 1.0 };
        }
        for _ in 0..CHORDS {
            let share = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            let at = (share, beyond(share));
            if at.1 < 0.0 { low = at } else { high = at }
        }
        low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1)
    }
}

#[cfg(test)]
mod tests {
    use super::{Ball, Rubble, direction};
    use cullet_geometry::Vec3;
    use cullet_geometry::math::unit;

    /// A heap of balls of all sizes in a box of 8 cells, some of them flattened or stretched.
    fn heap(seed: u64) -> Rubble {
        let number = |k: u64, of: u64| unit(seed, of, k);
        let place = |k| 8.0 * Vec3::new(number(k, 0), number(k, 1), number(k, 2));
        let ball = |k: u64| {
            let (along, longer) = (direction(seed, k), 0.6 + 1.1 * number(k, 4));
            Ball::drawn_out(place(k), 0.8 + number(k, 3), &along, longer)
        };
        Rubble::new((0..60).map(ball).collect(), seed)
    }

    /// Twice as long along a direction is as much thinner across as keeps the volume.
    #[test]
    fn a_ball_is_drawn_out_at_the_same_volume() {
        let ball = Ball::drawn_out(Vec3::x(), 2.0, &Vec3::y(), 2.0);
        assert!((ball.form.determinant() - 1.0).abs() < 1e-12);
        assert!(ball.far(&(Vec3::x() + Vec3::y() * 2.0)).abs() < 1e-12);
        assert!(ball.far(&(Vec3::x() * (1.0 + 0.5_f64.sqrt()))).abs() < 1e-12);
        assert_eq!(Ball::drawn_out(Vec3::x(), 2.0, &Vec3::y(), 1.0), Ball::round(Vec3::x(), 2.0));
    }

    /// Pairs of places in different pieces of a heap.
    fn across(rubble: &Rubble) -> Vec<([Vec3; 2], [u32; 2])> {
        let at = |k: u64| 8.0 * Vec3::new(unit(9, 0, k), unit(9, 1, k), unit(9, 2, k));
        let ends = |k| [at(k), at(k) + Vec3::new(0.3, -0.2, 0.3)];
        let pairs = (0..4000).map(|k| (ends(k), ends(k).map(|x| rubble.nearest(0..60, &x))));
        let known = pairs.filter_map(|(ends, [a, b])| Some((ends, [a?, b?])));
        known.filter(|(_, [a, b])| a != b).collect()
    }

    #[test]
    fn an_edge_is_crossed_where_both_pieces_are_as_near() {
        let rubble = heap(3);
        let all = across(&rubble);
        assert!(all.len() > 400, "{}", all.len());
        for ([from, to], [one, two]) in all {
            let share = rubble.crossing(one, two, &from, &to);
            assert!((0.0..=1.0).contains(&share));
            let place = from + share * (to - from);
            let (way, beyond) = rubble.beyond(one, two, &place);
            assert!(beyond.abs() < 2e-2 && (way.norm() - 1.0).abs() < 1e-12, "{beyond} off");
        }
    }

    /// F26: borders are bent, by no more than keeps each piece in one.
    #[test]
    fn borders_are_bent_a_little() {
        let rubble = heap(4);
        let tilt = |x: Vec3, k: usize| {
            let step = Vec3::from_fn(|a, _| if a == k { 1e-5 } else { 0.0 });
            (rubble.bent(&(x + step)) - rubble.bent(&(x - step))) / 2e-5
        };
        let mut bends: Vec<f64> = (0..500)
            .map(|k| {
                let x = 8.0 * Vec3::new(unit(1, 0, k), unit(1, 1, k), unit(1, 2, k));
                let columns: Vec<Vec3> = (0..3).map(|axis| tilt(x, axis)).collect();
                let turn = cullet_geometry::Mat3::from_columns(&columns);
                assert!(turn.determinant() > 0.2, "folded at {x}");
                (turn - cullet_geometry::Mat3::identity()).norm()
            })
            .collect();
        bends.sort_unstable_by(f64::total_cmp);
        assert!((0.15..0.6).contains(&bends[250]), "{}", bends[250]);
    }
}
