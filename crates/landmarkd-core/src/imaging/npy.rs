//! Arrays as NumPy reads them: `.npy`, version 1.0, little endian, the last axis fastest.

/// The data start at a multiple of this, so that a file can be mapped.
const ALIGNMENT_BYTES: usize = 64;
/// Magic, version 1.0, and the two bytes that hold the header's length.
const PREAMBLE_BYTES: usize = 10;

/// A `.npy` file of 32-bit floating-point numbers.
///
/// # Panics
/// If `values` are not as many as the shape says.
pub fn npy_f32(shape: &[usize], values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}), }}", sides.trim_end());
    let unpadded = PREAMBLE_BYTES + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(ALIGNMENT_BYTES) - unpadded));
    header.push('\n');
    let length: usize = shape.iter().product();
    let mut bytes = Vec::with_capacity(PREAMBLE_BYTES + header.len() + length * size_of::<f32>());
    bytes.extend_from_slice(b"\x93NUMPY\x01\x00");
    bytes.extend_from_slice(&u16::try_from(header.len()).expect("a shape is short").to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    let head_bytes = bytes.len();
    bytes.extend(values.into_iter().flat_map(f32::to_le_bytes));
    assert_eq!(
        bytes.len() - head_bytes,
        length * size_of::<f32>(),
        "an array of {shape:?} holds {length} values"
    );
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_a_line_that_ends_at_a_multiple_of_64() {
        for shape in [&[2, 3][..], &[3, 480, 512], &[7]] {
            let length = shape.iter().product();
            let bytes = npy_f32(shape, std::iter::repeat_n(1.5, length));
            let header_bytes = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            assert_eq!((10 + header_bytes) % 64, 0);
            assert_eq!(bytes.len(), 10 + header_bytes + 4 * length);
            let header = std::str::from_utf8(&bytes[10..10 + header_bytes]).unwrap();
            assert!(header.ends_with('\n') && header.starts_with("{'descr': '<f4', 'fortran_order': False,"));
        }
        let bytes = npy_f32(&[7], std::iter::repeat_n(0.0, 7));
        assert!(String::from_utf8_lossy(&bytes).contains("'shape': (7,), }"), "one side is a tuple too");
    }

    #[test]
    fn values_are_little_endian_in_their_order() {
        let bytes = npy_f32(&[1, 2], [1.0, f32::NAN]);
        assert_eq!(bytes[bytes.len() - 8..bytes.len() - 4], [0, 0, 0x80, 0x3f]);
        assert!(f32::from_le_bytes(bytes[bytes.len() - 4..].try_into().unwrap()).is_nan());
    }

    #[test]
    #[should_panic(expected = "holds 4 values")]
    fn a_wrong_number_of_values_is_refused() {
        npy_f32(&[2, 2], [0.0; 3]);
    }
}
