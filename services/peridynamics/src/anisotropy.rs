//! Solids that are stiffer or stronger in some directions.

use cullet_geometry::{Mat3, Vec3};

/// Components of a fully symmetric tensor of fourth order.
pub const QUARTIC: usize = 15;

/// Cells along an edge of each face of the cube that directions are taken from.
const CELLS: usize = 64;

/// Which bonds of a point bear more, and which break sooner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondAnisotropy {
    /// Σw n⊗n⊗n⊗n, by indices a ≤ b ≤ c ≤ d in order \[1\].
    pub quartic: [f64; QUARTIC],
    /// a, the direction in which strength is another.
    pub axis: Vec3,
    /// s_c along a over that across: s_c(n) = s_c(1 − (1 − ratio)(n·a)²) \[1\].
    pub strength: f64,
}

/// An elastic tensor as bonds have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondElasticity {
    /// K \[Pa\].
    pub bulk: f64,
    /// μ \[Pa\].
    pub shear: f64,
    /// Of [`BondAnisotropy`].
    pub quartic: [f64; QUARTIC],
}

/// Indices a ≤ b ≤ c ≤ d of the components.
pub(crate) fn indices() -> impl Iterator<Item = [usize; 4]> {
    (0..81)
        .map(|k| [k / 27, k / 9 % 3, k / 3 % 3, k % 3])
        .filter(|[a, b, c, d]| a <= b && b <= c && c <= d)
}

/// The components in order.
fn each(of: impl Fn([usize; 4]) -> f64) -> [f64; QUARTIC] {
    let mut all = [0.0; QUARTIC];
    all.iter_mut().zip(indices()).for_each(|(x, abcd)| *x = of(abcd));
    all
}

/// n_a n_b n_c n_d.
pub(crate) fn components(n: &Vec3) -> [f64; QUARTIC] {
    each(|[a, b, c, d]| n[a] * n[b] * n[c] * n[d])
}

/// (δ_ab δ_cd + δ_ac δ_bd + δ_ad δ_bc)/15.
#[must_use]
pub fn isotropic() -> [f64; QUARTIC] {
    let delta = |a: usize, b: usize| f64::from(u8::from(a == b));
    each(|[a, b, c, d]| {
        (delta(a, b) * delta(c, d) + delta(a, c) * delta(b, d) + delta(a, d) * delta(b, c)) / 15.0
    })
}

impl BondAnisotropy {
    /// Of the paper's matrix G, which takes ω = δ/|Gξ| in place of δ/|ξ|: stiffness by 1/|Gn| over
    /// its mean, which leaves K as it is, and the strength of the direction that G stretches
    /// most by what it stretches the others on the mean. G has an inverse.
    #[must_use]
    pub fn of_matrix(g: &Mat3) -> Self {
        let share = |n: &Vec3| 1.0 / (g * n).norm();
        let (mut sum, mut all) = ([0.0; QUARTIC], 0.0);
        for k in 0..6 * CELLS * CELLS {
            let along = |i: usize| 2.0 * (i as f64 + 0.5) / CELLS as f64 - 1.0;
            let (face, u, v) = (k % 6, along(k / 6 % CELLS), along(k / 6 / CELLS));
            let mut x = Vec3::zeros();
            x[face % 3] = if face < 3 { 1.0 } else { -1.0 };
            (x[(face + 1) % 3], x[(face + 2) % 3]) = (u, v);
            // The angle that a cell of the face fills.
            let length = x.norm();
            let weight = share(&(x / length)) / (length * length * length);
            all += weight;
            let found = components(&(x / length));
            sum.iter_mut().zip(found).for_each(|(sum, x)| *sum += weight * x);
        }
        let own = (g.transpose() * g).symmetric_eigen();
        let most = own.eigenvalues.imax();
        let length = |k: usize| own.eigenvalues[k].max(0.0).sqrt();
        let others = 0.5 * (length((most + 1) % 3) + length((most + 2) % 3));
        let axis = own.eigenvectors.column(most).into_owned();
        let strength = others / length(most);
        Self { quartic: sum.map(|x| x / all), axis, strength }
    }
}

impl BondElasticity {
    /// Of the components C_abcd \[Pa\] of an elastic tensor that answers pressure by pressure, as
    /// cubic ones do: C = 15μ Q + (9K − 15μ) 1⊗1/9 with the fully symmetric Q.
    #[must_use]
    pub fn of_tensor(tensor: impl Fn([usize; 4]) -> f64) -> Self {
        let pairs = || (0..9).map(|k| [k / 3, k % 3]);
        let bulk = pairs().map(|[a, b]| tensor([a, a, b, b])).sum::<f64>() / 9.0;
        let shear = 0.1 * pairs().map(|[a, b]| tensor([a, b, a, b])).sum::<f64>() - 0.3 * bulk;
        let even = isotropic();
        let symmetric = each(|[a, b, c, d]| {
            (tensor([a, b, c, d]) + tensor([a, c, b, d]) + tensor([a, d, b, c])) / 3.0
        });
        let mut quartic = symmetric;
        for (x, even) in quartic.iter_mut().zip(even) {
            *x = (*x - (9.0 * bulk - 15.0 * shear) * even * 5.0 / 9.0) / (15.0 * shear);
        }
        Self { bulk, shear, quartic }
    }
}

#[cfg(test)]
mod tests {
    use super::{BondAnisotropy, BondElasticity, isotropic};
    use cullet_geometry::Mat3;

    #[test]
    fn no_anisotropy_gives_the_isotropic_tensor() {
        let none = BondAnisotropy::of_matrix(&(Mat3::identity() * 3.0));
        assert!((none.strength - 1.0).abs() < 1e-12);
        let delta = |a: usize, b: usize| f64::from(u8::from(a == b));
        let (lambda, mu) = (3.0, 2.0);
        let found = BondElasticity::of_tensor(|[a, b, c, d]| {
            lambda * delta(a, b) * delta(c, d)
                + mu * (delta(a, c) * delta(b, d) + delta(a, d) * delta(b, c))
        });
        assert!((found.bulk - 3.0 - 4.0 / 3.0).abs() < 1e-12 && (found.shear - 2.0).abs() < 1e-12);
        for (k, even) in isotropic().into_iter().enumerate() {
            assert!((none.quartic[k] - even).abs() < 1e-4, "{k}: {}", none.quartic[k]);
            assert!((found.quartic[k] - even).abs() < 1e-12, "{k}: {}", found.quartic[k]);
        }
    }
}
