use super::format::{Expected, Metric, Reduction};
use super::metric::{MetricVerdict, reduce, speeds, weigh};
use super::{Specimen, load, schema, whole};
use cullet_geometry::Vec3;
use cullet_model::strength::Region;
use cullet_specimen::{Amplitude, LoadKind, Probe};

const HEAD: &str = r#"
[geometry]
shape = { kind = "box", size = ["10 cm", "4 cm", "2 cm"] }
[material]
name = "stone"
density = 2450
young = "32 GPa"
poisson = 0.2
strength = "3 MPa"
fracture_energy = 3
[solver]
spacing = "1 cm"
[run]
end = "1 ms"
"#;

/// The schemas beside the catalogue are those of the types.
#[test]
fn the_schemas_in_the_tree_are_the_types() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/specimens");
    for (name, text) in [("specimen", schema()), ("whole", whole::schema())] {
        let path = format!("{folder}/{name}.schema.json");
        if std::env::var_os("CULLET_BLESS").is_some() {
            std::fs::write(&path, &text).expect("writes");
        }
        let written = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(written == text, "cullet schema --{name} > tests/specimens/{name}.schema.json");
    }
}

fn read(text: &str, overrides: &[&str]) -> Result<Specimen, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("thing.toml");
    std::fs::write(&file, text).expect("a file");
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    load(&file, &overrides).map_err(|errors| errors.to_string())
}

fn good(tail: &str) -> Specimen {
    read(&format!("{HEAD}{tail}"), &[]).unwrap_or_else(|why| panic!("{why}"))
}

/// Each of these is refused at that line and column with these words.
fn told(cases: &[(&str, &str, &str)]) {
    for (tail, place, words) in cases {
        let told = read(&format!("{HEAD}{tail}\n"), &[]).expect_err(tail);
        assert!(told.contains(words), "{tail}\n{told}");
        assert!(told.contains(&format!("toml:{place}")), "{tail}\n{told}");
    }
}

/// Each error names the line of its value and the bound.
#[test]
fn errors_name_their_place_and_bound() {
    let cases = [
        ("[solver2]\nx = 1", "15:2", "unknown key `solver2`"),
        ("[[load]]\nname = \"a\"\nregion = \"+x\"", "", "one of them; it has 0"),
        ("[[load]]\nname = \"a\"\nregion = \"+w\"\npressure = 1", "17:10", "no region \"+w\""),
        ("[[load]]\nname = \"a\"\nregion = \"+x\"\npressure = \"1 m\"", "18:12", "not a unit"),
        ("[[probe]]\nname = \"a\"\nkind = \"kinetik\"", "17:8", "did you mean `kinetic`"),
        ("[[probe]]\nname = \"a\"\nkind = \"stress\"", "", "`component` is missing"),
        (
            "[[probe]]\nname = \"a\"\nkind = \"stress\"\ncomponent = \"x\"",
            "18:13",
            "a tensor has xx",
        ),
        ("[[probe]]\nname = \"a\"\nkind = \"kinetic\"\nat = [0, 0, 0]", "18:6", "takes no `at`"),
        (
            "[[probe]]\nname = \"a\"\nkind = \"reaction\"\nsupport = \"s\"\ncomponent = \"x\"",
            "18:11",
            "no support \"s\"",
        ),
        ("[[metric]]\nname = \"m\"\nprobe = \"p\"\nreduce = \"max\"", "17:9", "no probe \"p\""),
        ("[expect.m]\nvalue = 1", "15:1", "no metric \"m\""),
        ("[[symmetry]]\naxis = \"q\"", "16:8", "not one of x, y, z"),
        ("[[notch]]\npoint = [0, 0, 0]\nnormal = [0, 0, 0]", "17:10", "a length above"),
        ("[[support]]\nname = \"s\"\nregion = \"-x\"\naxes = \"xw\"", "18:8", "`w` is no axis"),
        (
            "[[zone]]\nregion = \"+w\"\nmaterial = { name = \"m\", preset = \"glass\" }",
            "16:10",
            "no region \"+w\"",
        ),
        (
            "[[zone]]\nregion = \"+x\"\n[zone.material]\nname = \"m\"\npreset = \"glass\"\n\
             weibull = 5",
            "20:11",
            "a zone takes no `weibull`",
        ),
        (
            "[[zone]]\nregion = \"+x\"\nmaterial = { name = \"m\", young = \"1 GPa\" }",
            "",
            "`density` is missing",
        ),
        ("[[body]]\nshape = { kind = \"box\", size = [1, 1, 1] }", "", "`position`"),
        (
            "[[probe]]\nname = \"k\"\nkind = \"kinetic\"\n[[metric]]\nname = \"m\"\n\
             probe = \"k\"\nreduce = \"max\"\nminus = \"m\"",
            "22:9",
            "no metric \"m\" before this one",
        ),
        (
            "[[load]]\nname = \"a\"\nregion = \"+x\"\npressure = 1\n\
             time = { kind = \"table\", times = [0, 2, 1], factors = [0, 1, 1] }",
            "19:8",
            "must ascend",
        ),
    ];
    told(&cases);
    let spacing = read(HEAD, &["spacing=0"]).expect_err("a bound");
    assert!(spacing.contains("must be above 0 m; it is 0 m"), "{spacing}");
    let missing = read(&HEAD.replace("spacing = \"1 cm\"", ""), &[]).expect_err("no spacing");
    assert!(missing.contains("`spacing` is missing"), "{missing}");
}

/// What would be read as something else, or as nothing, is reported where it stands.
#[test]
fn boxes_inside_out_and_names_given_twice_are_told() {
    let cases = [
        (
            "[[region]]\nname = \"r\"\n\
             parts = [{ kind = \"ball\", centre = [0, 0, 0], radius = 1 },\n\
             { kind = \"box\", min = [0, \"2 cm\", 0], max = [0, \"1 cm\", 0] }]",
            "18:1",
            "`min` is above `max` along y: 0.02 m, 0.01 m",
        ),
        (
            "[[support]]\nname = \"s\"\nregion = \"-x\"\n\
             [[support]]\nname = \"s\"\nregion = \"+x\"",
            "19:8",
            "a second support is called s",
        ),
        (
            "[[load]]\nname = \"s\"\nregion = \"-x\"\npressure = 1\n\
             [[load]]\nname = \"s\"\nregion = \"+x\"\npressure = 1",
            "20:8",
            "a second load is called s",
        ),
        (
            "[[probe]]\nname = \"s\"\nkind = \"kinetic\"\n\
             [[probe]]\nname = \"s\"\nkind = \"elastic\"",
            "19:8",
            "a second probe is called s",
        ),
        (
            "[[probe]]\nname = \"s\"\nkind = \"kinetic\"\n\
             [[metric]]\nname = \"m\"\nprobe = \"s\"\nreduce = \"max\"\n\
             [[metric]]\nname = \"m\"\nprobe = \"s\"\nreduce = \"min\"",
            "23:8",
            "a second metric is called m",
        ),
    ];
    told(&cases);
}

/// Sides are planes for what acts on them, and one spacing deep for what is read off points.
#[test]
fn a_side_has_the_depth_of_its_use() {
    let specimen = good(
        "[[load]]\nname = \"pull\"\nregion = \"+x\"\ntraction = [\"1 MPa\", 0, 0]\n\
         time = { kind = \"ramp\", rise = \"1 us\" }\n\
         [[probe]]\nname = \"end\"\nkind = \"broken\"\nregion = \"+x\"",
    );
    let problem = &specimen.job().expect("a body").0;
    let load = &problem.loads[0];
    assert_eq!(load.push, LoadKind::Traction(Vec3::x() * 1e6));
    assert_eq!(load.course, Amplitude::Table(vec![(0.0, 0.0), (1e-6, 1.0)]));
    let side = |x: f64| Region::HalfSpace { point: Vec3::x() * x, normal: -Vec3::x() };
    assert_eq!(load.part, [side(0.05)]);
    let probes = &problem.output.probes;
    let Probe::Broken(part) = &probes[0] else { panic!("{probes:?}") };
    assert_eq!(part, &[side(0.05 - 0.01)]);
}

#[test]
fn overrides_reach_tables_lists_by_name_and_the_solver_by_one_name() {
    let tail = "[[load]]\nname = \"pull\"\nregion = \"+x\"\npressure = \"1 MPa\"";
    let set = ["spacing=5mm", "material.young=1 GPa", "load.pull.pressure=2 MPa", "samples=7"];
    let specimen = read(&format!("{HEAD}{tail}"), &set).unwrap_or_else(|why| panic!("{why}"));
    let problem = &specimen.job().expect("a body").0;
    assert_eq!((problem.settings.spacing, problem.matter.material.young), (0.005, 1e9));
    assert_eq!((problem.loads[0].push, problem.output.samples), (LoadKind::Pressure(2e6), 7));
}

/// A slot takes its volume out of the body.
#[test]
fn a_slot_is_cut_out() {
    let slot = "[[slot]]\nshape = { kind = \"box\", size = [\"2 cm\", \"8 cm\", \"1 cm\"] }\n\
                position = [0, 0, \"1 cm\"]";
    let volume = good(slot).job().expect("a body").0.body.mesh.signed_volume();
    let wanted = 0.1 * 0.04 * 0.02 - 0.02 * 0.04 * 0.005;
    assert!((volume / wanted - 1.0).abs() < 1e-9, "{volume} of {wanted}");
}

fn metric(reduce: Reduction) -> Metric {
    Metric {
        name: "m".into(),
        probe: "p".into(),
        reduce,
        from: None,
        until: None,
        time: None,
        threshold: None,
        window: None,
        scale: 1.0,
        offset: 0.0,
        minus: None,
        over: None,
    }
}

/// A damped wave has the period, the decrement and the crossings that it was made with.
#[test]
fn metrics_find_what_a_wave_was_made_with() {
    let (period, decay) = (0.25, 0.4);
    let times: Vec<f64> = (0..=4000).map(|k| f64::from(k) * 1e-3).collect();
    let wave = |t: f64| {
        let turn = 2.0 * std::f64::consts::PI * t / period;
        0.001 + libm::exp(-decay * t) * libm::sin(turn)
    };
    let values: Vec<f64> = times.iter().map(|&t| wave(t)).collect();
    let is = |metric: Metric, wanted: f64, most: f64| {
        let value = reduce(&metric, &times, &values);
        assert!((value - wanted).abs() <= most, "{metric:?}: {value} of {wanted}");
    };
    is(metric(Reduction::Period), period, 1e-3);
    is(metric(Reduction::Decrement), decay * period, 2e-3);
    is(metric(Reduction::First), 0.001, 0.0);
    is(metric(Reduction::TimeOfMax), period / 4.0, 2e-3);
    is(Metric { time: Some(0.12345), ..metric(Reduction::At) }, wave(0.12345), 1e-4);
    let half = Metric { threshold: Some(0.5), ..metric(Reduction::TimeReached) };
    is(half, period / 12.0, 2e-4);
    is(Metric { scale: -2.0, ..metric(Reduction::First) }, -0.002, 1e-15);
}

#[test]
fn metrics_of_a_straight_line_are_its_own() {
    let times: Vec<f64> = (0..=10).map(f64::from).collect();
    let values: Vec<f64> = times.iter().map(|t| 3.0 * t - 6.0).collect();
    let value = |metric: Metric| reduce(&metric, &times, &values);
    assert!((value(metric(Reduction::Slope)) - 3.0).abs() < 1e-12);
    let steep = Metric { window: Some(4.0), ..metric(Reduction::MaxSlope) };
    assert!((value(steep) - 3.0).abs() < 1e-12);
    assert!((value(metric(Reduction::Mean)) - 9.0).abs() < 1e-12);
    assert!((value(metric(Reduction::Range)) - 30.0).abs() < 1e-12);
    let above = Metric { threshold: Some(0.0), ..metric(Reduction::TimeAbove) };
    assert!((value(above) - 8.0).abs() < 1e-12);
    let window = Metric { from: Some(2.0), until: Some(4.0), ..metric(Reduction::Integral) };
    assert!((value(window) - 6.0).abs() < 1e-12);
    assert!(value(metric(Reduction::Period)).is_nan());
    let straight = Metric { offset: 6.0, from: Some(1.0), ..metric(Reduction::Exponent) };
    assert!((value(straight) - 1.0).abs() < 1e-12);
    assert!(value(metric(Reduction::Exponent)).is_nan(), "there is no logarithm of -6");
}

/// A tip that stands, then runs at 2: its speed, a window late.
#[test]
fn speeds_are_those_of_the_last_window() {
    let times: Vec<f64> = (0..=10).map(f64::from).collect();
    let places: Vec<f64> = times.iter().map(|t| 2.0 * (t - 4.0).max(0.0)).collect();
    let found = speeds(&times, &places, 2.0);
    assert_eq!(found.len(), 11);
    for (at, wanted) in [(0, 0.0), (1, 0.0), (4, 0.0), (5, 1.0), (6, 2.0), (10, 2.0)] {
        assert!((found[at] - wanted).abs() < 1e-12, "{found:?}");
    }
}

/// A body that cannot be made is reported with its place beside a specimen that was read; what is
/// wrong with the file is still an error.
#[test]
fn a_body_that_cannot_be_made_is_a_flaw_and_no_error() {
    let ring = "geometry.shape={kind=\"torus\",ring_radius=1,tube_radius=2}";
    let with = |more: &[&str]| {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("x.toml");
        let text = "[geometry]\nshape = { kind = \"sphere\", radius = 1 }\n\
            [material]\nname = \"m\"\npreset = \"steel\"\n[solver]\nspacing = 0.1\n\
            [run]\nend = 1\n";
        std::fs::write(&file, text).expect("a file");
        load(&file, &more.iter().map(|&one| one.to_owned()).collect::<Vec<_>>())
    };
    assert_eq!(with(&[]).expect("a specimen").flaw, None);
    let flaw = with(&[ring]).expect("a specimen").flaw.expect("a flaw");
    assert!(flaw.starts_with("geometry: torus minor radius is 2"), "{flaw}");
    let errors = with(&[ring, "step_factor=-1"]).expect_err("an error").to_string();
    assert!(errors.contains("step_factor") && !errors.contains("torus"), "{errors}");
    let help = with(&["spacng=1"]).expect_err("an error").to_string();
    assert!(help.contains("did you mean `spacing`?"), "{help}");
}

#[test]
fn a_gap_is_no_failure_and_what_is_no_number_never_holds() {
    let expected = Expected { value: Some(2.0), tolerance: Some(0.1), ..Expected::default() };
    let verdict = |expected: &Expected, value| weigh(Some(expected), value).verdict;
    assert_eq!(verdict(&expected, 2.19), MetricVerdict::Holds);
    assert_eq!(verdict(&expected, 2.21), MetricVerdict::Fails);
    assert_eq!(verdict(&expected, f64::NAN), MetricVerdict::Fails);
    let gap = Expected { gap: Some("why".into()), ..expected };
    assert_eq!(verdict(&gap, 2.21), MetricVerdict::Gap);
    assert_eq!(verdict(&gap, 2.1), MetricVerdict::Holds);
    assert_eq!(weigh(None, 1.0).verdict, MetricVerdict::Free);
}

/// Zones and further bodies arrive in the order of the file, each body where its triangles begin.
#[test]
fn zones_and_bodies_arrive() {
    let specimen = good(
        "[[zone]]\nregion = \"+x\"\nmaterial = { name = \"m\", preset = \"steel\", density = 5 }\n\
         [[body]]\nshape = { kind = \"sphere\", radius = \"1 cm\" }\nposition = [\"6 cm\", 0, 0]\n\
         [[body]]\nshape = { kind = \"box\", size = [1, 1, 1] }\nposition = [2, 0, 0]\n",
    );
    let problem = &specimen.job().expect("a body").0;
    assert_eq!(problem.matter.zones.len(), 1);
    assert_eq!(problem.matter.zones[0].material.density, 5.0);
    assert!(problem.matter.zones[0].material.young > 1e11);
    let all = problem.body.mesh.triangles.len() as u32;
    let [first, second] = problem.body.parts[..] else { panic!("{:?}", problem.body.parts) };
    assert!(first == 12 && second == all - 12, "{first} {second} of {all}");
    let (low, high) = problem.body.mesh.bounds().expect("bounds");
    assert!((low.x + 0.05).abs() < 1e-12 && (high.x - 2.5).abs() < 1e-12);
}

/// Only what looks at one sample is not spoiled by another.
#[test]
fn a_sample_that_is_no_number_is_not_passed_over() {
    let metric = |reduce: &str| -> Metric {
        let text = format!("name = \"m\"\nprobe = \"p\"\nreduce = \"{reduce}\"\ntime = 2.5");
        toml::from_str(&text).expect("a metric")
    };
    let (times, values) = ([0.0, 1.0, 2.0, 3.0], [f64::NAN, 1.0, 5.0, 3.0]);
    for name in ["max", "min", "mean", "range", "max-size", "slope", "drift", "first"] {
        assert!(reduce(&metric(name), &times, &values).is_nan(), "{name}");
    }
    assert_eq!(reduce(&metric("final"), &times, &values), 3.0);
    assert_eq!(reduce(&metric("at"), &times, &values), 4.0);
}
