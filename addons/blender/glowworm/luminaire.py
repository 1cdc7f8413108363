"""Photometric files (IES LM-63-2002) of lamps that look alike from all sides of their axis."""
import math

LUMENS_OF_WATT = 179  # by which Glowworm reads such files


def write(path, share, cone):
    """Writes a lamp of 1 W sr^-1 times share(angle), where angle runs from 0 on the axis to the cone's, in radians."""
    angles = [math.degrees(cone) * i / 180 for i in range(181)]
    candela = [LUMENS_OF_WATT * share(math.radians(angle)) for angle in angles]
    if angles[-1] < 90:
        # Beyond the edge the lamp is dark.
        angles += [angles[-1] + 1e-4, 90]
        candela += [0, 0]
    rows = [f'1 -1 1 {len(angles)} 1 1 2 0 0 0', '1 1 1', ' '.join(f'{a:.7g}' for a in angles), '0',
            ' '.join(f'{c:.7g}' for c in candela)]
    with open(path, 'w', encoding='ascii') as file:
        file.write('\r\n'.join(['IESNA:LM-63-2002', 'TILT=NONE', *rows]) + '\r\n')
