use super::super::chart;
use super::*;

const BAR: &str = r#"
[geometry]
shape = { kind = "box", size = ["10 cm", "2 cm", "2 cm"] }
[material]
name = "stone"
density = 2450
young = "32 GPa"
poisson = 0.2
[solver]
spacing = "1 cm"
breaks = false
[run]
end = "1 ms"
[[probe]]
name = "energy"
kind = "kinetic"
[[metric]]
name = "most"
probe = "energy"
reduce = "max"
[[metric]]
name = "least"
probe = "energy"
reduce = "min"
[expect.most]
value = 2.0
tolerance = "10 %"
source = "made up"
"#;

const SET: &str = r#"
description = "a set"
[[chart]]
name = "bar"
title = "a bar"
specimen = "bar.toml"
metric = "most"
along = "spacing=2cm,1 cm,5mm"
[[chart.option]]
name = "double"
[[chart.option]]
name = "single"
set = ["precision=single"]
along = "spacing=2cm,1cm"
"#;

fn folder(set: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("bar.toml"), BAR).expect("a file");
    std::fs::write(folder.path().join("set.toml"), set).expect("a file");
    folder
}

fn loaded(text: &str, quick: bool) -> Set {
    let folder = folder(text);
    load(&folder.path().join("set.toml"), &[], quick).unwrap_or_else(|errors| panic!("{errors}"))
}

fn wrong(text: &str) -> String {
    let folder = folder(text);
    let errors = load(&folder.path().join("set.toml"), &[], false).expect_err("it is wrong");
    errors.to_string()
}

/// A row of the chart of `SET`.
fn row(option: &str, spacing: f64, seed: u64, cpu: f64, value: Option<f64>) -> FrontierRow {
    FrontierRow {
        chart: "bar".to_owned(),
        option: option.to_owned(),
        along: format!("spacing={spacing}"),
        seed,
        standard: option == "double" && spacing == 0.01,
        bench: "bar".to_owned(),
        solver: "brittle".to_owned(),
        spacing,
        step: 1e-6,
        per_cell: 8.0,
        precision: "double".to_owned(),
        threads: 1,
        wall: 2.0 * cpu,
        cpu,
        steps: 10,
        particle_steps: 1000,
        peak: 1 << 20,
        metric: "most".to_owned(),
        value,
        reference: 2.0,
        error: value.map(|v| (v - 2.0) / 2.0),
        status: if value.is_some() { "ok" } else { "refused" }.to_owned(),
    }
}

/// Double halves its error of 40 % with each four times the cost; single stops at 20 %.
fn sample() -> Vec<FrontierRow> {
    vec![
        row("double", 0.02, 1, 1.0, Some(2.8)),
        row("double", 0.01, 1, 4.0, Some(2.4)),
        row("double", 0.005, 1, 16.0, Some(2.2)),
        row("single", 0.02, 1, 0.5, Some(2.9)),
        row("single", 0.01, 1, 2.0, None),
    ]
}

#[test]
fn a_set_is_a_run_for_each_point_and_seed() {
    let set = loaded(SET, false);
    let chart = &set.charts[0];
    assert_eq!((chart.reference, chart.scale, chart.source.as_str()), (2.0, 2.0, "made up"));
    let runs: Vec<(&str, &str, bool)> =
        chart.runs.iter().map(|r| (&*r.option, &*r.along, r.standard)).collect();
    let expected = [
        ("double", "spacing=2cm", false),
        ("double", "spacing=1 cm", true),
        ("double", "spacing=5mm", false),
        ("single", "spacing=2cm", false),
        ("single", "spacing=1cm", false),
    ];
    assert_eq!(runs, expected, "the default is where the file has it, whatever it is written as");
    let seeds =
        SET.replace("along = \"spacing=2cm,1 cm,5mm\"", "along = \"spacing=2cm\"\nseeds = 8");
    let runs = &loaded(&seeds, false).charts[0].runs;
    assert_eq!(runs.len(), 8 + 16);
    assert_eq!(runs.iter().take(8).map(|r| r.seed).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(loaded(&seeds, true).charts[0].runs.len(), 2 + 4);
    let named = SET.replace("title", "default = \"5mm\"\ntitle");
    let standard: Vec<bool> =
        loaded(&named, false).charts[0].runs.iter().map(|r| r.standard).collect();
    assert_eq!(standard, [false, false, true, false, false]);
}

/// Twins are one run: the second curve's first point is the first one's.
#[test]
fn equal_work_has_one_name() {
    let same = SET.replace("precision=single", "precision=double");
    let runs = loaded(&same, false).charts.remove(0).runs;
    assert_eq!((&runs[0].id, &runs[1].id), (&runs[3].id, &runs[4].id));
    assert_ne!(runs[0].id, runs[1].id);
}

#[test]
fn what_is_wrong_with_a_set_is_told_with_its_place() {
    let cases = [
        (SET.replace("metric = \"most\"", "metrik = \"most\""), "unknown key `metrik`"),
        (SET.replace("\"most\"", "\"mist\""), "metrics are: most, least"),
        (SET.replace("\"most\"", "\"least\""), "give a `reference`"),
        (SET.replace("title", "seeds = 3\ntitle"), "at least 8; it is 3"),
        // Of a scene as of a specimen.
        (SET.replace("specimen = \"bar.toml\"", "scene = \"x\"\nseeds = 7"), "at least 8; it is 7"),
        (SET.replace("title", "seeds = 65\ntitle"), "at most 64"),
        (SET.replace("title", "scale = 0\ntitle"), "above 0"),
        (SET.replace("title", "default = \"3mm\"\ntitle"), "\"3mm\" is not along"),
        (SET.replace("title", "scene = \"x\"\ntitle"), "one of them"),
        (SET.replace("title", "finest = [\"a=1\"]\ntitle"), "`finest` is for scenes"),
        (SET.replace("precision=single", "precision=half"), "\"half\" is not one of"),
        (SET.replace("spacing=2cm,1cm", "spacing"), "KEY=VALUE"),
        (SET.replace("name = \"single\"", "name = \"double\""), "\"double\" is empty or taken"),
        (SET.replace("name = \"bar\"", "name = \"b/r\""), "letters, digits"),
        (SET.replace("bar.toml", "none.toml"), "no such file"),
        ("description = \"none\"".to_owned(), "`[[chart]]`"),
    ];
    for (text, told) in cases {
        let said = wrong(&text);
        assert!(said.contains(told), "{told}:\n{said}");
        assert!(said.contains("set.toml:"), "{told} has no place:\n{said}");
    }
    let twice = format!("{SET}{}", SET.replace("description = \"a set\"", ""));
    assert!(wrong(&twice).contains("\"bar\" is taken"));
    let folder = folder(SET);
    let only = load(&folder.path().join("set.toml"), &["rab".to_owned()], false);
    assert!(only.expect_err("no such chart").to_string().contains("known: bar"));
}

#[test]
fn rows_are_read_as_they_were_written() {
    let mut all = sample();
    all[1].option = "a, \"b\"".to_owned();
    all[2].bench.clear();
    all[2].along = "=1+1".to_owned();
    let text = csv(&all);
    assert!(text.contains(",'=1+1,"), "a spreadsheet would compute it: {text}");
    assert!(text.starts_with("chart,option,along,seed,standard,bench,solver,h,dt,ppc,"), "{text}");
    assert_eq!(rows(&text).expect("rows"), all);
    assert_eq!(rows("").expect("none"), []);
    let bad = text.replace(",1000,", ",many,");
    let said = rows(&bad).expect_err("many is no number");
    assert!(said.contains("line 2") && said.contains("particle_steps"), "{said}");
    assert!(rows("chart,option\nbar,double\n").expect_err("columns").contains("no column"));
}

/// Error 40 % at 1 s, 20 % at 4 s, 10 % at 16 s: slope −½.
#[test]
fn a_chart_is_read_off_its_rows() {
    let set = loaded(SET, false);
    let reading = read(&set.charts[0], &sample());
    assert_eq!(reading.curves, ["double", "single"]);
    assert_eq!(reading.pareto, [3, 0, 1, 2], "single is cheaper at 45 %");
    let ten = reading.costs[0][0].expect("10 %");
    assert!((ten.cost - 16.0).abs() < 1e-9 && !ten.at_most, "{ten:?}");
    assert_eq!((reading.costs[0][1], reading.costs[1]), (None, [None, None]));
    assert_eq!(reading.cheapest.map(|k| k.map(|k| reading.spots[k].cost)), [Some(16.0), None]);
    assert_eq!(reading.spots[4].failed.as_deref(), Some("refused"));
    let limit = reading.limits[0].filter(|limit| !limit.lost).expect("4h, 2h, h").estimate;
    assert!((limit.value - 2.0).abs() < 1e-9 && (limit.order - 1.0).abs() < 1e-9, "{limit:?}");
    assert_eq!(reading.limits[1], None);
    let text = text(&set.charts[0], &reading);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for line in [
        "*P double spacing=0.01 4.00 s 2.40 20 %",
        "single spacing=0.01 2.00 s refused",
        "to 10 %: double at spacing=0.005, 16.0 s; along curves: double 16.0 s, single not reached",
        "to 3 %: no point;",
        "double: order 1.00, limit 2.00, GCI 11 %",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

/// Eight seeds of mean 2.4, ±0.1 by turns: variance 0.08/7, half a band 2.365 √(0.01/7).
#[test]
fn an_ensemble_is_a_point_with_a_band() {
    let set = loaded(SET, false);
    let value = |k: u64| 2.4 + if k.is_multiple_of(2) { 0.1 } else { -0.1 };
    let mut all: Vec<FrontierRow> =
        (1..=8).map(|k| row("double", 0.01, k, k as f64, Some(value(k)))).collect();
    let reading = read(&set.charts[0], &all);
    assert_eq!((reading.spots.len(), reading.seeds, reading.spots[0].cost), (1, 8, 4.5));
    let (size, low, high) = reading.spots[0].error.expect("an error");
    let half = 2.365 * (0.01_f64 / 7.0).sqrt() / 2.0;
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(near(size, 0.2) && near(high - size, half) && near(size - low, half), "{size} {half}");
    // 20 % are within 21 %; its band, half of it 4.5 %, is not.
    assert_eq!(doubt(&reading.spots[0], 0.21), " (band to 24 %)");
    assert_eq!(doubt(&reading.spots[0], 0.3), "");
    // Three such points at 4h, 2h, h, a hundredth apart: within their bands.
    let points = [(0.04, 0.03), (0.02, 0.01), (0.01, 0.0)].map(|(h, more)| {
        (1..=8).map(move |k| row("double", h, k, k as f64, Some(value(k) + more)))
    });
    let three: Vec<FrontierRow> = points.into_iter().flatten().collect();
    assert!(read(&set.charts[0], &three).limits[0].expect("a limit").lost);
    all[3].value = None;
    all[3].status = "nan".to_owned();
    let reading = read(&set.charts[0], &all);
    assert_eq!(reading.spots[0].failed.as_deref(), Some("nan, 1 of 8 seeds"));
    assert_eq!((reading.spots[0].error, reading.pareto.len()), (None, 0));
    // Ended well, and what was asked for never happened.
    all[3].status = "ok".to_owned();
    let reading = read(&set.charts[0], &all);
    assert_eq!(reading.spots[0].failed.as_deref(), Some("no value, 1 of 8 seeds"));
}

/// What is drawn: circles for points, rings for the Pareto set, a diamond for the default, a cross
/// for what failed, at the top.
#[test]
fn a_chart_shows_every_point() {
    let set = loaded(SET, false);
    let chart = &set.charts[0];
    let reading = read(chart, &sample());
    let svg = chart::svg(chart, &reading, "here").expect("a chart");
    assert_eq!(svg, chart::svg(chart, &read(chart, &sample()), "here").expect("a chart"));
    let count = |what: &str| svg.matches(what).count();
    // Four points, two curves and two marks in the legend; five rings.
    assert_eq!((count("r=\"5\""), count("r=\"8\"")), (4 + 2 + 2, 4 + 1), "{svg}");
    // A cross in the plot and one in the key, two strokes each.
    assert_eq!(count("stroke-width=\"3\""), 4);
    let cross = svg.lines().find(|line| line.contains("stroke-width=\"3\"")).expect("a cross");
    assert!(cross.contains(",97 ") && cross.contains(",111 "), "not about the top line: {cross}");
    for text in ["bar: a bar", "16.0 s", "not reached", "made up", "here", "10 %", "0.5 s"] {
        assert!(svg.contains(text), "{text}\n{svg}");
    }
    // A failed point parts the line: what is left of the second colour's is in the legend.
    let mut parted = sample();
    parted.push(row("single", 0.005, 1, 8.0, Some(2.3)));
    let svg = chart::svg(chart, &read(chart, &parted), "here").expect("a chart");
    assert_eq!(svg.matches("stroke=\"#D55E00\" stroke-width=\"2\"").count(), 1, "{svg}");
    let picture = chart::picture(chart, &reading, "here").expect("a chart");
    let blue = picture.rgb.chunks(3).filter(|c| *c == [0, 114, 178]).count();
    assert!(blue > 500, "{blue} pixels of the first curve");
    assert_eq!(picture, chart::picture(chart, &reading, "here").expect("a chart"));
    let none = read(chart, &[]);
    assert!(chart::svg(chart, &none, "").is_ok() && chart::picture(chart, &none, "").is_ok());
}

const SCENE: &str = r#"
[fracture]
max_particles = 3000
[[body]]
name = "ball"
shape = { kind = "sphere", radius = "5 cm" }
position = [0, 0, 1]
material = "soda-lime-glass"
"#;

const SHARES: &str = r#"
[[chart]]
name = "ball"
scene = "ball.toml"
metric = "share of pieces sampled"
along = "points=0.5,1,2"
default = "1"
[[chart.option]]
name = "of the pieces"
[[chart.option]]
name = "of their mass"
metric = "share of mass sampled"
"#;

fn shares(text: &str) -> Result<Set, String> {
    let folder = folder(text);
    std::fs::write(folder.path().join("ball.toml"), SCENE).expect("a file");
    load(&folder.path().join("set.toml"), &[], false).map_err(|errors| errors.to_string())
}

/// A scene's points are multiplied, whatever it has; both shares are read off the same runs.
#[test]
fn what_is_sampled_is_charted_over_multiples_of_a_scenes_points() {
    let runs = shares(SHARES).expect("a set").charts.remove(0).runs;
    let told: Vec<(&str, &str, bool)> =
        runs.iter().map(|run| (&*run.metric, &*run.along, run.standard)).collect();
    let (pieces, mass) = ("share of pieces sampled", "share of mass sampled");
    let expected = [
        (pieces, "points=0.5", false),
        (pieces, "points=1", true),
        (pieces, "points=2", false),
        (mass, "points=0.5", false),
        (mass, "points=1", false),
        (mass, "points=2", false),
    ];
    assert_eq!(told, expected);
    let points = ["1500", "3000", "6000", "1500", "3000", "6000"];
    for (run, points) in runs.iter().zip(points) {
        assert_eq!(run.id, format!("fracture.max_particles={points} world.seed=1"));
    }
    let cases = [
        (SHARES.replace("0.5,1", "0,1"), "above 0 and at most 1000; it is \"0\""),
        (SHARES.replace("0.5,1", "few,1"), "it is \"few\""),
        (SHARES.replace("share of mass sampled", "mass distance"), "of a chart of either"),
        (SHARES.replace("share of pieces sampled", "mass distance"), "of a chart of either"),
        (SHARES.replace("share of pieces sampled", "shares"), "it is one of \"mass distance\""),
        (SHARES.replace("along", "finest = [\"world.seed=2\"]\nalong"), "held against"),
    ];
    for (text, what) in cases {
        let said = shares(&text).expect_err("it is wrong");
        assert!(said.contains(what) && said.contains("set.toml:"), "{what}:\n{said}");
    }
}

/// A curve that shows another number than its chart undercuts nothing.
#[test]
fn the_share_of_mass_is_no_rival_of_that_of_pieces() {
    let chart = shares(SHARES).expect("a set").charts.remove(0);
    let row = |option: &str, metric: &str, cpu: f64, share: f64| FrontierRow {
        chart: "ball".to_owned(),
        metric: metric.to_owned(),
        reference: 0.0,
        ..row(option, 0.01, 1, cpu, Some(share))
    };
    let (pieces, mass) = ("share of pieces sampled", "share of mass sampled");
    let rows = [row("of the pieces", pieces, 1.0, 0.8), row("of their mass", mass, 1.0, 0.1)];
    let reading = read(&chart, &rows);
    assert_eq!((reading.pareto, reading.cheapest), (vec![0], [None, None]));
    let text = text(&chart, &read(&chart, &rows));
    assert!(text.contains("80 %") && text.contains("10 %"), "{text}");
}

#[test]
fn the_schema_in_the_tree_is_that_of_the_types() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/frontier/frontier.schema.json");
    let text = std::fs::read_to_string(path).expect("the schema");
    assert_eq!(text, schema(), "cullet schema --frontier > tests/frontier/frontier.schema.json");
}
