//! Rigid bodies on elastic joints: how the joints share what the bodies need.
//!
//! Each body needs an impulse and a torque impulse from its joints. With displacements u of the
//! bodies a joint gives K_j times that of its ends against each other, so K u = needed, and of all
//! joint loads that are in balance with the needs these have the least elastic energy.
//!
//! K is solved by conjugate gradients. Its preconditioner is a Cholesky factor, which is kept as
//! long as it serves: while the same bodies and joints hardly move against each other, two or three
//! iterations do. What no joint can give, as of a group in free flight whose needs do not quite add
//! up to nothing, goes into a spring to the ground at each body that is as stiff as the body is
//! heavy and weaker than the joints by [`GROUND`].

use crate::exchange::Exchange;
use crate::skyline::{Skyline, dot};
use cullet_geometry::{Mat3, Vec3};
use nalgebra::{Matrix3x6, Matrix6};

/// A joint between two bodies, or between a body and what never moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameElement {
    /// Places of the bodies; the second one gets what the element gives.
    pub(crate) ends: [Option<usize>; 2],
    /// From the centre of each to where the element holds it \[m\].
    pub(crate) arms: [Vec3; 2],
    /// Force over displacement, of any common unit.
    pub(crate) force: Mat3,
    /// Torque over rotation, likewise.
    pub(crate) torque: Mat3,
}

/// What holds a body beside its joints: its mass \[kg\] and inertia \[kg·m²\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameNode {
    pub(crate) mass: f64,
    pub(crate) inertia: Mat3,
}

/// Stiffness of the springs to the ground over that of the joints \[1\].
const GROUND: f64 = 1e-12;
/// Energy of what is not yet in balance over that of all, square root \[1\].
const TOLERANCE: f64 = 1e-9;
/// Iterations with a factor that fits; then it is made anew, and they begin again.
const MOST_ITERATIONS: usize = 40;
/// Iterations without a factor, which would be too large.
const MOST_WITHOUT: usize = 400;
/// Multiplications of the largest factor: a second of one core.
const DEAREST: f64 = 1e9;
/// A pivot below this share of its diagonal is rounding \[1\].
const LEAST_PIVOT: f64 = 1e-15;

/// A factor, kept for the next step.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeptFactor(Option<Factor>);

#[derive(Clone, Debug)]
enum Factor {
    Whole(Skyline),
    /// Of each body by itself.
    Blocks(Vec<Matrix6<f64>>),
}

/// What the frame came to.
pub(crate) struct FrameSolution {
    /// What each element gives its second end, about where it holds it.
    pub(crate) given: Vec<Exchange>,
    pub(crate) converged: bool,
}

/// A frame and what its bodies need.
pub(crate) struct ElasticFrame<'a> {
    pub(crate) nodes: &'a [FrameNode],
    pub(crate) elements: &'a [FrameElement],
    /// For each row of bodies the first one that it is joined to.
    pub(crate) first: &'a [usize],
    /// Stiffness of the springs to the ground per mass.
    ground: f64,
}

impl<'a> ElasticFrame<'a> {
    pub(crate) fn new(
        nodes: &'a [FrameNode],
        elements: &'a [FrameElement],
        first: &'a [usize],
    ) -> Self {
        let stiffness: f64 = elements.iter().map(|e| e.force.trace() / 3.0).sum();
        let mass: f64 = nodes.iter().map(|node| node.mass).sum();
        let mean = stiffness / elements.len().max(1) as f64;
        Self { nodes, elements, first, ground: GROUND * mean * nodes.len() as f64 / mass }
    }

    /// What each element gives so that the bodies get what they need.
    pub(crate) fn solve(&self, needed: &[Exchange], kept: &mut KeptFactor) -> FrameSolution {
        if self.ground <= 0.0 {
            // Slack ropes alone give nothing.
            let given = self.elements.iter().map(|_| Exchange::zero()).collect();
            return FrameSolution { given, converged: true };
        }
        let b: Vec<f64> =
            needed.iter().flat_map(|n| n.linear.iter().chain(n.torque.iter()).copied()).collect();
        let fits = match &kept.0 {
            Some(Factor::Whole(matrix)) => matrix.len() == b.len(),
            Some(Factor::Blocks(blocks)) => blocks.len() == self.nodes.len(),
            None => false,
        };
        let mut x = vec![0.0; b.len()];
        let mut converged = false;
        if fits && let Some(factor) = &kept.0 {
            converged = self.iterate(&b, factor, &mut x);
        }
        if !converged {
            let factor = self.factor();
            x = vec![0.0; b.len()];
            converged = self.iterate(&b, &factor, &mut x);
            kept.0 = Some(factor);
        }
        FrameSolution { given: self.elements.iter().map(|e| given(e, &x)).collect(), converged }
    }

    fn iterate(&self, b: &[f64], factor: &Factor, x: &mut [f64]) -> bool {
        let mut r = b.to_vec();
        let mut z = precondition(factor, &r);
        let mut p = z.clone();
        let mut energy = dot(&r, &z);
        let enough = energy * TOLERANCE * TOLERANCE;
        let most = if matches!(factor, Factor::Whole(_)) { MOST_ITERATIONS } else { MOST_WITHOUT };
        for _ in 0..most {
            if energy.is_nan() || energy <= enough {
                return !energy.is_nan();
            }
            let q = self.times(&p);
            let curvature = dot(&p, &q);
            if curvature.is_nan() || curvature <= 0.0 {
                return false;
            }
            let step = energy / curvature;
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += step * p);
            r.iter_mut().zip(&q).for_each(|(r, q)| *r -= step * q);
            z = precondition(factor, &r);
            let next = dot(&r, &z);
            let share = next / energy;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + share * *p);
            energy = next;
        }
        energy <= enough
    }

    /// K x.
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (k, node) in self.nodes.iter().enumerate() {
            let (u, w) = at(x, k);
            add(&mut y, k, &(u * (self.ground * node.mass)), &(node.inertia * w * self.ground));
        }
        for element in self.elements {
            let Exchange { linear, torque } = given(element, x);
            for ((end, arm), sign) in element.ends.iter().zip(&element.arms).zip([-1.0, 1.0]) {
                if let Some(k) = *end {
                    add(&mut y, k, &(linear * sign), &((torque + arm.cross(&linear)) * sign));
                }
            }
        }
        y
    }

    fn factor(&self) -> Factor {
        let scalar: Vec<usize> = self.first.iter().flat_map(|&first| [6 * first; 6]).collect();
        if Skyline::cost(&scalar) > DEAREST {
            return Factor::Blocks(self.blocks());
        }
        let mut matrix = Skyline::new(scalar);
        for (k, block) in self.diagonal_springs().into_iter().enumerate() {
            put(&mut matrix, (k, k), &block);
        }
        for element in self.elements {
            // One between bodies that the skyline does not know is left to the iterations.
            if let [Some(i), Some(j)] = element.ends
                && !matrix.keeps(6 * i.max(j), 6 * i.min(j))
            {
                continue;
            }
            for (k, l, block) in blocks_of(element) {
                if l <= k {
                    put(&mut matrix, (k, l), &block);
                }
            }
        }
        matrix.factor(LEAST_PIVOT);
        Factor::Whole(matrix)
    }

    fn blocks(&self) -> Vec<Matrix6<f64>> {
        let mut blocks = self.diagonal_springs();
        for element in self.elements {
            for (k, l, block) in blocks_of(element) {
                if k == l {
                    blocks[k] += block;
                }
            }
        }
        let inverse = |block: Matrix6<f64>| block.cholesky().map(|factor| factor.inverse());
        blocks.into_iter().map(|block| inverse(block).unwrap_or_else(Matrix6::identity)).collect()
    }

    fn diagonal_springs(&self) -> Vec<Matrix6<f64>> {
        let spring = |node: &FrameNode| {
            let mut block = Matrix6::zeros();
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Mat3::identity() * node.mass));
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(&node.inertia);
            block * self.ground
        };
        self.nodes.iter().map(spring).collect()
    }
}

fn at(x: &[f64], k: usize) -> (Vec3, Vec3) {
    let x = &x[6 * k..6 * k + 6];
    (Vec3::new(x[0], x[1], x[2]), Vec3::new(x[3], x[4], x[5]))
}

fn add(y: &mut [f64], k: usize, linear: &Vec3, torque: &Vec3) {
    let y = &mut y[6 * k..6 * k + 6];
    for i in 0..3 {
        y[i] += linear[i];
        y[3 + i] += torque[i];
    }
}

/// What an element gives its second end at displacements `x`.
fn given(element: &FrameElement, x: &[f64]) -> Exchange {
    let (mut slide, mut turn) = (Vec3::zeros(), Vec3::zeros());
    for ((end, arm), sign) in element.ends.iter().zip(&element.arms).zip([-1.0, 1.0]) {
        if let Some(k) = *end {
            let (u, w) = at(x, k);
            slide += (u + w.cross(arm)) * sign;
            turn += w * sign;
        }
    }
    Exchange { linear: element.force * slide, torque: element.torque * turn }
}

/// The blocks of K that an element adds, each with its row and column of bodies.
fn blocks_of(element: &FrameElement) -> Vec<(usize, usize, Matrix6<f64>)> {
    let ends: Vec<(usize, f64, Matrix3x6<f64>)> = (0..2)
        .filter_map(|side| {
            let mut moves = Matrix3x6::zeros();
            moves.fixed_view_mut::<3, 3>(0, 0).copy_from(&Mat3::identity());
            let arm = element.arms[side].cross_matrix();
            moves.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm);
            Some((element.ends[side]?, [-1.0, 1.0][side], moves))
        })
        .collect();
    let mut blocks = Vec::with_capacity(4);
    for (k, sign_k, moves_k) in &ends {
        for (l, sign_l, moves_l) in &ends {
            let mut block = moves_k.transpose() * element.force * moves_l;
            let mut turn = block.fixed_view_mut::<3, 3>(3, 3);
            turn += element.torque;
            blocks.push((*k, *l, block * (sign_k * sign_l)));
        }
    }
    blocks
}

fn put(matrix: &mut Skyline, (k, l): (usize, usize), block: &Matrix6<f64>) {
    for i in 0..6 {
        for j in 0..6 {
            let (row, column) = (6 * k + i, 6 * l + j);
            if column <= row {
                matrix.add(row, column, block[(i, j)]);
            }
        }
    }
}

fn precondition(factor: &Factor, r: &[f64]) -> Vec<f64> {
    let mut z = r.to_vec();
    match factor {
        Factor::Whole(matrix) => matrix.solve(&mut z),
        Factor::Blocks(blocks) => {
            for (part, block) in z.chunks_exact_mut(6).zip(blocks) {
                let own = block * nalgebra::Vector6::from_column_slice(part);
                part.copy_from_slice(own.as_slice());
            }
        }
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODE: FrameNode =
        FrameNode { mass: 2.0, inertia: Mat3::new(0.3, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.3) };

    fn element(i: Option<usize>, j: usize, arms: [Vec3; 2], stiffness: f64) -> FrameElement {
        let (force, torque) = (Mat3::identity() * stiffness, Mat3::identity() * 0.1 * stiffness);
        FrameElement { ends: [i, Some(j)], arms, force, torque }
    }

    /// A row of bodies one metre apart on a wall, each needing a unit of lift.
    fn row(n: usize) -> (Vec<FrameElement>, Vec<Exchange>, Vec<usize>) {
        let half = Vec3::x() * 0.5;
        let elements = (0..n).map(|k| element(k.checked_sub(1), k, [half, -half], 1.0)).collect();
        let needed = vec![Exchange { linear: Vec3::z(), torque: Vec3::zeros() }; n];
        (elements, needed, (0..n).map(|k| k.saturating_sub(1)).collect())
    }

    #[test]
    fn a_cantilever_has_what_balance_asks_for() {
        let (elements, needed, first) = row(5);
        let nodes = [NODE; 5];
        let mut kept = KeptFactor::default();
        let frame = ElasticFrame::new(&nodes, &elements, &first);
        let root = frame.solve(&needed, &mut kept);
        assert!(root.converged);
        for (k, given) in root.given.iter().enumerate() {
            let beyond = (5 - k) as f64;
            assert!((given.linear - Vec3::z() * beyond).norm() < 1e-8, "{given:?}");
            let bending = -Vec3::y() * (beyond * beyond / 2.0);
            assert!((given.torque - bending).norm() < 1e-7, "{given:?}");
        }
        // The same by blocks alone.
        kept.0 = Some(Factor::Blocks(frame.blocks()));
        let again = frame.solve(&needed, &mut kept);
        assert!((again.given[0].torque - root.given[0].torque).norm() < 1e-6);
    }

    #[test]
    fn joints_side_by_side_share_by_their_stiffness() {
        let arms = |y: f64| [Vec3::zeros(), Vec3::new(0.0, y, 0.5)];
        let elements = [element(None, 0, arms(1.0), 1.0), element(None, 0, arms(-1.0), 1.0)];
        let needed = [Exchange { linear: Vec3::z() * 6.0, torque: Vec3::zeros() }];
        let nodes = [NODE];
        let frame = ElasticFrame::new(&nodes, &elements, &[0]);
        let given = frame.solve(&needed, &mut KeptFactor::default()).given;
        assert!((given[0].linear.z - 3.0).abs() < 1e-9 && (given[1].linear.z - 3.0).abs() < 1e-9);
        let elements = [element(None, 0, arms(0.0), 1.0), element(None, 0, arms(0.0), 2.0)];
        let frame = ElasticFrame::new(&nodes, &elements, &[0]);
        let given = frame.solve(&needed, &mut KeptFactor::default()).given;
        assert!((given[0].linear.z - 2.0).abs() < 1e-9 && (given[1].linear.z - 4.0).abs() < 1e-9);
    }

    /// Two bodies in free flight, one pushed: the joint gives the other its half, and what no joint
    /// can give is left to the ground.
    #[test]
    fn a_free_group_is_solved_as_well() {
        let half = Vec3::x() * 0.5;
        let elements = [element(Some(0), 1, [half, -half], 1.0)];
        let needed = [
            Exchange { linear: -Vec3::x(), torque: Vec3::zeros() },
            Exchange { linear: Vec3::x() * 1.02, torque: Vec3::zeros() },
        ];
        let nodes = [NODE; 2];
        let frame = ElasticFrame::new(&nodes, &elements, &[0, 0]);
        let solution = frame.solve(&needed, &mut KeptFactor::default());
        assert!(
            (solution.given[0].linear - Vec3::x() * 1.01).norm() < 1e-4,
            "{:?}",
            solution.given
        );
    }
}
