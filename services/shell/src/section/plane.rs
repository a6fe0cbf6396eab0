//! Symmetric 2×2 of the plane, as 11, 22, 12.

/// Greatest principal value of a symmetric 2×2 (11, 22, 12) and its unit direction.
pub(super) fn principal(s: &[f64; 3]) -> (f64, [f64; 2]) {
    let (mean, half) = (0.5 * (s[0] + s[1]), 0.5 * (s[0] - s[1]));
    let radius = (half * half + s[2] * s[2]).sqrt();
    // The longer of the two columns of s − (mean − radius) 1.
    let (x, y) = if half >= 0.0 { (half + radius, s[2]) } else { (s[2], radius - half) };
    let length = (x * x + y * y).sqrt();
    let direction = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
    (mean + radius, direction)
}

/// Components nn, tt, nt of a symmetric 2×2 in the frame of n̂.
pub(super) fn turned(e: &[f64; 3], [x, y]: [f64; 2]) -> [f64; 3] {
    let [e11, e22, e12] = *e;
    [
        e11 * x * x + e22 * y * y + 2.0 * e12 * x * y,
        e11 * y * y + e22 * x * x - 2.0 * e12 * x * y,
        (e22 - e11) * x * y + e12 * (x * x - y * y),
    ]
}

/// The same back: components 11, 22, 12 of one in the frame of n̂.
pub(super) fn turned_back(s: &[f64; 3], [x, y]: [f64; 2]) -> [f64; 3] {
    turned(s, [x, -y])
}

#[cfg(test)]
mod tests {
    use super::{principal, turned, turned_back};

    #[test]
    fn principal_values_and_turns_are_exact() {
        for s in [[3.0, -1.0, 2.0], [-1.0, 3.0, 2.0], [2.0, 2.0, 0.0], [0.0, 1.0, 0.0]] {
            let (value, direction) = principal(&s);
            let there = turned(&s, direction);
            assert!((there[0] - value).abs() < 1e-14 && there[2].abs() < 1e-14, "{s:?} {there:?}");
            assert!(there[1] <= value);
            let back = turned_back(&there, direction);
            (0..3).for_each(|k| assert!((back[k] - s[k]).abs() < 1e-14));
        }
    }
}
