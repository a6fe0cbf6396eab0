//! Quantities: SI numbers, or text with a unit ("6 mm", "70 GPa", "2.5 g/cm3", "30 deg", "1/240
//! s").

use schemars::{Schema, SchemaGenerator, json_schema};

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// \[m\]
    Length,
    /// \[s\]
    Time,
    /// \[m/s\]
    Velocity,
    /// \[m/s²\]
    Acceleration,
    /// \[rad\]
    Angle,
    /// \[rad/s\]
    AngularVelocity,
    /// \[kg/m³\]
    Density,
    /// \[Pa\]
    Pressure,
    /// \[J/m²\]
    EnergyPerArea,
    /// \[N·s\]
    Impulse,
    /// \[N\]
    Force,
    /// \[N·m\]
    Moment,
    /// \[1/s\]
    Rate,
    /// \[K\]
    TemperatureDifference,
    /// \[J/(kg K)\]
    HeatCapacity,
    /// \[1\]
    Ratio,
}

const PI: f64 = std::f64::consts::PI;

impl Dimension {
    /// Every dimension.
    pub const ALL: [Self; 16] = [
        Self::Length,
        Self::Time,
        Self::Velocity,
        Self::Acceleration,
        Self::Angle,
        Self::AngularVelocity,
        Self::Density,
        Self::Pressure,
        Self::EnergyPerArea,
        Self::Impulse,
        Self::Force,
        Self::Moment,
        Self::Rate,
        Self::TemperatureDifference,
        Self::HeatCapacity,
        Self::Ratio,
    ];

    /// The units that text may name and what one of each is in SI; the first is the SI unit.
    #[must_use]
    pub const fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Length => &[
                ("m", 1.0),
                ("mm", 1e-3),
                ("cm", 1e-2),
                ("dm", 1e-1),
                ("km", 1e3),
                ("um", 1e-6),
                ("in", 0.0254),
                ("ft", 0.3048),
            ],
            Self::Time => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0)],
            Self::Velocity => &[
                ("m/s", 1.0),
                ("mm/s", 1e-3),
                ("cm/s", 1e-2),
                ("km/s", 1e3),
                ("km/h", 1.0 / 3.6),
                ("mph", 0.44704),
                ("ft/s", 0.3048),
            ],
            Self::Acceleration => &[("m/s2", 1.0), ("cm/s2", 1e-2), ("gn", 9.80665)],
            Self::Angle => &[("rad", 1.0), ("deg", PI / 180.0), ("turn", 2.0 * PI)],
            Self::AngularVelocity => &[
                ("rad/s", 1.0),
                ("deg/s", PI / 180.0),
                ("rev/s", 2.0 * PI),
                ("rpm", 2.0 * PI / 60.0),
            ],
            Self::Density => {
                &[("kg/m3", 1.0), ("g/cm3", 1e3), ("g/cc", 1e3), ("kg/l", 1e3), ("t/m3", 1e3)]
            }
            Self::Pressure => &[
                ("Pa", 1.0),
                ("kPa", 1e3),
                ("MPa", 1e6),
                ("GPa", 1e9),
                ("N/m2", 1.0),
                ("N/mm2", 1e6),
                ("psi", 6_894.757_293_168),
                ("ksi", 6.894_757_293_168e6),
            ],
            Self::EnergyPerArea => {
                &[("J/m2", 1.0), ("kJ/m2", 1e3), ("N/m", 1.0), ("N/mm", 1e3), ("mJ/m2", 1e-3)]
            }
            Self::Impulse => {
                &[("N s", 1.0), ("Ns", 1.0), ("mN s", 1e-3), ("kN s", 1e3), ("kg m/s", 1.0)]
            }
            Self::Force => &[("N", 1.0), ("mN", 1e-3), ("kN", 1e3), ("MN", 1e6)],
            Self::Moment => {
                &[("N m", 1.0), ("Nm", 1.0), ("mN m", 1e-3), ("kN m", 1e3), ("MN m", 1e6)]
            }
            Self::Rate => &[("1/s", 1.0), ("1/ms", 1e3), ("1/us", 1e6), ("Hz", 1.0)],
            Self::TemperatureDifference => &[("K", 1.0)],
            Self::HeatCapacity => &[("J/(kg K)", 1.0), ("kJ/(kg K)", 1e3)],
            Self::Ratio => &[("", 1.0), ("%", 1e-2)],
        }
    }

    /// The name that stands in the schema.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Time => "time",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Angle => "angle",
            Self::AngularVelocity => "angular velocity",
            Self::Density => "density",
            Self::Pressure => "pressure",
            Self::EnergyPerArea => "energy per area",
            Self::Impulse => "impulse",
            Self::Force => "force",
            Self::Moment => "moment",
            Self::Rate => "rate",
            Self::TemperatureDifference => "temperature difference",
            Self::HeatCapacity => "heat capacity",
            Self::Ratio => "ratio",
        }
    }

    /// The dimension of that schema name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|dimension| dimension.name() == name)
    }

    /// The SI unit.
    #[must_use]
    pub const fn si(self) -> &'static str {
        self.units()[0].0
    }
}

/// Reads "6 mm" and the like as SI.
///
/// # Errors
/// A sentence that says what is wrong and which units are known.
pub fn parse(text: &str, dimension: Dimension) -> Result<f64, String> {
    let tidy = tidy(text);
    let split = number_length(&tidy);
    let (number, unit) = (tidy[..split].trim(), tidy[split..].trim());
    let Some(number) = parse_number(number) else {
        return Err(format!("\"{text}\" does not begin with a number"));
    };
    let units = dimension.units();
    if unit.is_empty() && dimension != Dimension::Ratio {
        return Err(format!("\"{text}\" has no unit; a bare number is in {}", dimension.si()));
    }
    match units.iter().find(|(name, _)| *name == unit) {
        Some((_, factor)) => Ok(number * factor),
        None => {
            let names: Vec<&str> =
                units.iter().map(|(name, _)| *name).filter(|name| !name.is_empty()).collect();
            Err(format!(
                "\"{unit}\" is not a unit of {}; known: {}",
                dimension.name(),
                names.join(", ")
            ))
        }
    }
}

/// One spelling for the many ways to write a unit.
fn tidy(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.trim().chars() {
        match c {
            'µ' | 'μ' => plain.push('u'),
            '²' => plain.push('2'),
            '³' => plain.push('3'),
            '·' | '*' | '⋅' => plain.push(' '),
            '°' => plain.push_str("deg"),
            '^' | '_' => {}
            '\u{a0}' | '\u{202f}' => plain.push(' '),
            other => plain.push(other),
        }
    }
    plain
}

/// Length \[bytes\] of the leading number or fraction.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let exponent = matches!(bytes[at], b'e' | b'E')
            && at > 0
            && bytes[at - 1].is_ascii_digit()
            && bytes.get(at + 1).is_some_and(|&next| {
                next.is_ascii_digit()
                    || matches!(next, b'+' | b'-')
                        && bytes.get(at + 2).is_some_and(u8::is_ascii_digit)
            });
        let fraction = bytes[at] == b'/' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit);
        if !(bytes[at].is_ascii_digit()
            || matches!(bytes[at], b'+' | b'-' | b'.')
            || exponent
            || fraction)
        {
            break;
        }
        at += 1;
    }
    at
}

fn parse_number(text: &str) -> Option<f64> {
    match text.split_once('/') {
        Some((over, under)) => {
            let (over, under): (f64, f64) = (over.trim().parse().ok()?, under.trim().parse().ok()?);
            (under != 0.0).then_some(over / under)
        }
        None => text.parse().ok(),
    }
}

fn scalar(dimension: Dimension) -> Schema {
    json_schema!({ "type": ["number", "string"], "x-unit": dimension.name() })
}

fn triple(item: &Schema) -> Schema {
    json_schema!({ "type": "array", "items": item, "minItems": 3, "maxItems": 3 })
}

macro_rules! schemas {
    ($($name:ident: $dimension:ident,)*) => { $(
        /// The schema of a number, or text, of that dimension.
        pub fn $name(_: &mut SchemaGenerator) -> Schema {
            scalar(Dimension::$dimension)
        }
    )* };
}

macro_rules! vector_schemas {
    ($($name:ident: $dimension:ident,)*) => { $(
        /// The schema of three numbers, or texts, of that dimension.
        pub fn $name(_: &mut SchemaGenerator) -> Schema {
            triple(&scalar(Dimension::$dimension))
        }
    )* };
}

schemas! {
    length: Length,
    time: Time,
    density: Density,
    pressure: Pressure,
    energy_per_area: EnergyPerArea,
    impulse: Impulse,
    ratio: Ratio,
    angle: Angle,
    rate: Rate,
    temperature_difference: TemperatureDifference,
    heat_capacity: HeatCapacity,
    velocity: Velocity,
    acceleration: Acceleration,
    force: Force,
    moment: Moment,
}

vector_schemas! {
    length3: Length,
    velocity3: Velocity,
    acceleration3: Acceleration,
    angular_velocity3: AngularVelocity,
    pressure3: Pressure,
    force3: Force,
}

/// A list of times.
pub fn times(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "items": scalar(Dimension::Time), "minItems": 1 })
}

/// Three lengths above zero.
pub fn size3(_: &mut SchemaGenerator) -> Schema {
    triple(&json_schema!({
        "type": ["number", "string"], "x-unit": Dimension::Length.name(), "exclusiveMinimum": 0
    }))
}

/// Two lengths.
pub fn length2(_: &mut SchemaGenerator) -> Schema {
    pair(Dimension::Length)
}

fn pair(dimension: Dimension) -> Schema {
    json_schema!({ "type": "array", "items": scalar(dimension), "minItems": 2, "maxItems": 2 })
}

fn points() -> Schema {
    json_schema!({
        "type": "array",
        "items": pair(Dimension::Length),
        "minItems": 2,
        "maxItems": 4096,
    })
}

/// A list of points in a plane, two lengths each.
pub fn points2(_: &mut SchemaGenerator) -> Schema {
    points()
}

/// A list of lines in a plane, each a list of points.
pub fn lines2(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "items": points(), "maxItems": 256 })
}

/// Three shares, each from 0 to 1.
pub fn colour(_: &mut SchemaGenerator) -> Schema {
    let part = json_schema!({ "type": "number", "minimum": 0, "maximum": 1 });
    triple(&part)
}

/// A list of places, three lengths each.
pub fn places3(_: &mut SchemaGenerator) -> Schema {
    let place = triple(&scalar(Dimension::Length));
    json_schema!({ "type": "array", "items": place, "maxItems": 1024 })
}

/// A list of polygons in space, each a list of points.
pub fn polygons3(_: &mut SchemaGenerator) -> Schema {
    let point = triple(&scalar(Dimension::Length));
    let polygon = json_schema!({
        "type": "array", "items": point, "minItems": 3, "maxItems": 256
    });
    json_schema!({ "type": "array", "items": polygon, "maxItems": 1024 })
}

#[cfg(test)]
mod tests {
    use super::{Dimension, parse};

    #[test]
    fn text_with_units_is_si() {
        let cases = [
            ("6 mm", Dimension::Length, 0.006),
            ("70GPa", Dimension::Pressure, 70e9),
            ("2.5 g/cm³", Dimension::Density, 2500.0),
            ("1/240 s", Dimension::Time, 1.0 / 240.0),
            ("180°", Dimension::Angle, std::f64::consts::PI),
            ("-1.5e-1 m", Dimension::Length, -0.15),
            ("7.4 J/m^2", Dimension::EnergyPerArea, 7.4),
            ("5 N·s", Dimension::Impulse, 5.0),
            ("50 %", Dimension::Ratio, 0.5),
            ("0.5", Dimension::Ratio, 0.5),
        ];
        for (text, dimension, expected) in cases {
            let value = parse(text, dimension).unwrap_or_else(|why| panic!("{text}: {why}"));
            assert!((value - expected).abs() <= 1e-12 * expected.abs(), "{text}: {value}");
        }
        for (text, dimension) in [
            ("6", Dimension::Length),
            ("mm", Dimension::Length),
            ("6 kg", Dimension::Length),
            ("1/0 s", Dimension::Time),
            ("", Dimension::Ratio),
        ] {
            assert!(parse(text, dimension).is_err(), "{text} must be refused");
        }
    }
}
