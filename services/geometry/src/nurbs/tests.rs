use super::{NurbsError, NurbsPatch, SplineAxis};
use crate::math::Vec3;

/// Values and derivatives against differences, on uneven knots, a ring and a rational patch.
#[test]
fn derivatives_agree_with_differences() {
    let uneven = SplineAxis::clamped(3, vec![0., 0., 0., 0., 0.7, 1.0, 2.5, 3., 3., 3., 3.]);
    for axis in [uneven.unwrap(), SplineAxis::ring(2, 5).unwrap()] {
        for span in axis.spans() {
            let (at, step) = (0.37, 1e-5);
            let [before, here, after] =
                [-1.0, 0.0, 1.0].map(|s| axis.evaluate(&span, at + s * step / span.length));
            for k in 0..=axis.degree() {
                let slope = (after.value[k] - before.value[k]) / (2.0 * step);
                let bend = (after.first[k] - before.first[k]) / (2.0 * step);
                assert!((slope - here.first[k]).abs() < 1e-8, "{slope} {}", here.first[k]);
                assert!((bend - here.second[k]).abs() < 1e-7, "{bend} {}", here.second[k]);
            }
            let total: f64 = here.value.iter().sum();
            assert!((total - 1.0).abs() < 1e-14);
        }
    }
    let patch = hemisphere();
    let spans = patch.axes().clone().map(|axis| axis.spans());
    let at = |du: f64, dv: f64| patch.evaluate([&spans[0][1], &spans[1][2]], [0.3 + du, 0.6 + dv]);
    let (step, here) = (1e-5, at(0.0, 0.0));
    let length = [spans[0][1].length, spans[1][2].length];
    for k in 0..here.count {
        let along = |of: &dyn Fn(f64) -> f64, axis: usize| {
            (of(step) - of(-step)) / (2.0 * step * length[axis])
        };
        let wanted = [
            along(&|s| at(s, 0.0).value[k], 0),
            along(&|s| at(0.0, s).value[k], 1),
            along(&|s| at(s, 0.0).derivatives[0][k], 0),
            along(&|s| at(0.0, s).derivatives[1][k], 1),
            along(&|s| at(0.0, s).derivatives[0][k], 1),
        ];
        for (d, wanted) in wanted.iter().enumerate() {
            let found = here.derivatives[d][k];
            assert!((found - wanted).abs() < 1e-6, "derivative {d} of {k}: {found}, not {wanted}");
        }
    }
}

/// A quarter of a hemisphere with a hole of 18°, radius 10.
fn hemisphere() -> NurbsPatch {
    let (top, half) = (72.0_f64.to_radians(), 36.0_f64.to_radians());
    let middle = [10.0, 10.0 * half.tan(), half.cos()];
    let profile = [[10.0, 0.0, 1.0], middle, [10.0 * top.cos(), 10.0 * top.sin(), 1.0]];
    NurbsPatch::revolved(profile, std::f64::consts::FRAC_PI_2).unwrap().divided([4, 4])
}

#[test]
fn a_refined_arc_is_the_same_arc() {
    let patch = hemisphere();
    let spans = patch.axes().clone().map(|axis| axis.spans());
    assert_eq!((spans[0].len(), spans[1].len(), patch.points().len()), (4, 4, 36));
    for u in &spans[0] {
        for v in &spans[1] {
            let place = patch.place(&patch.evaluate([u, v], [0.21, 0.79]));
            assert!((place.norm() - 10.0).abs() < 1e-12, "{}", place.norm());
        }
    }
}

/// Cells inside a uniform patch have the same functions, bit for bit: they share their tables.
#[test]
fn inner_cells_of_a_sheet_have_equal_bits() {
    let patch = NurbsPatch::sheet([0.4, 0.3], [40, 30], 2).unwrap();
    let spans = patch.axes().clone().map(|axis| axis.spans());
    let at = |i: usize, j: usize| patch.evaluate([&spans[0][i], &spans[1][j]], [0.2113, 0.7887]);
    let (one, other) = (at(3, 4), at(29, 17));
    assert_eq!((one.value, one.derivatives), (other.value, other.derivatives));
    let corner = patch.place(&patch.evaluate([&spans[0][0], &spans[1][29]], [0.0, 1.0]));
    assert!((corner - Vec3::new(-0.2, 0.15, 0.0)).norm() < 1e-15);
}

#[test]
fn bad_knots_are_refused_with_their_place() {
    let clamped = |degree, knots: &[f64]| SplineAxis::clamped(degree, knots.to_vec()).unwrap_err();
    assert_eq!(clamped(4, &[0.0]), NurbsError::Degree(4));
    assert_eq!(
        clamped(2, &[0., 0., 0., 2., 1., 3., 3., 3.]),
        NurbsError::Knot { index: 4, value: 1.0 }
    );
    assert_eq!(
        clamped(2, &[0., 0., 0., 1., 1., 3., 3., 3.]),
        NurbsError::Crease { value: 1.0, times: 2, degree: 2, most: 1 }
    );
    assert_eq!(
        clamped(2, &[0., 0., 1., 1., 3., 3., 3.]),
        NurbsError::Clamped { end: "first", wanted: 3, times: 2 }
    );
    let axis = SplineAxis::uniform(2, 2).unwrap();
    let short = NurbsPatch::new([axis.clone(), axis], vec![Vec3::zeros(); 15], vec![1.0; 16]);
    assert_eq!(
        short.unwrap_err(),
        NurbsError::Count { what: "control points", found: 15, wanted: 16 }
    );
}
