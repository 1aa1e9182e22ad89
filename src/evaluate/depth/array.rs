//! Arrays as NumPy writes them, read: two axes of 32- or 64-bit floating-point numbers, little endian, rows first.

use serde_json::Value;

/// A plane of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major.
    pub values: Vec<f64>,
}

impl Plane {
    /// The plane of a `.npy` file; `None` if it is no such array.
    pub fn of_npy(bytes: &[u8]) -> Option<Plane> {
        let (&[major, _], rest) = bytes.strip_prefix(b"\x93NUMPY")?.split_first_chunk()?;
        let (length, rest) = match major {
            1 => {
                let (length, rest) = rest.split_first_chunk()?;
                (usize::from(u16::from_le_bytes(*length)), rest)
            }
            _ => {
                let (length, rest) = rest.split_first_chunk()?;
                (usize::try_from(u32::from_le_bytes(*length)).ok()?, rest)
            }
        };
        let (header, data) = rest.split_at_checked(length)?;
        let header = std::str::from_utf8(header).ok()?;
        // The header is a literal of Python; these few marks make it JSON.
        let json = header.replace('\'', "\"").replace("False", "false").replace("True", "true");
        let json = json.replace(", }", "}").replace(",)", ")").replace('(', "[").replace(')', "]");
        let header: Value = serde_json::from_str(json.trim()).ok()?;
        let side = |axis: usize| header["shape"][axis].as_u64().and_then(|side| usize::try_from(side).ok());
        let (height, width) = (side(0)?, side(1)?);
        if header["fortran_order"] != Value::Bool(false) || header["shape"].as_array()?.len() != 2 {
            return None;
        }
        let values: Vec<f64> = match header["descr"].as_str()? {
            "<f4" => data.as_chunks().0.iter().map(|value| f64::from(f32::from_le_bytes(*value))).collect(),
            "<f8" => data.as_chunks().0.iter().map(|value| f64::from_le_bytes(*value)).collect(),
            _ => return None,
        };
        (Some(values.len()) == width.checked_mul(height)).then_some(Plane { width, height, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::imaging::npy::npy_f32;

    #[test]
    fn what_the_service_writes_is_read_back() {
        let bytes = npy_f32(&[2, 3], [1.0, 2.5, f32::NAN, 4.0, 5.0, 6.0]);
        let plane = Plane::of_npy(&bytes).unwrap();
        assert_eq!((plane.width, plane.height), (3, 2));
        assert_eq!((plane.values[1], plane.values[5]), (2.5, 6.0));
        assert!(plane.values[2].is_nan());
        assert_eq!(Plane::of_npy(&bytes[..bytes.len() - 4]), None, "a number is missing");
        assert_eq!(Plane::of_npy(&npy_f32(&[1, 2, 3], [0.0; 6])), None, "three axes");
    }

    #[test]
    fn doubles_are_read_and_other_orders_are_not() {
        let file = |header: &str| {
            let length = u16::try_from(header.len()).unwrap().to_le_bytes();
            let data = [1.5_f64, -2.0].map(f64::to_le_bytes).concat();
            [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &data].concat()
        };
        let plane = Plane::of_npy(&file("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }\n"));
        assert_eq!(plane.unwrap().values, [1.5, -2.0]);
        let other =
            ["{'descr': '<f8', 'fortran_order': True, 'shape': (1, 2), }", "{}", "", "{'descr': '<i8'"];
        assert!(other.iter().all(|header| Plane::of_npy(&file(header)).is_none()));
    }
}
