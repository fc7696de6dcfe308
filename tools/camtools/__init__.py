"""Tables, reports and helpers of camturn around the firmware's cam tables.

From a drawing to the bytes that the firmware plays:

>>> from camtools.part import example_part
>>> from camtools.generate import generate
>>> from camtools.image import pack, unpack
>>> result = generate(example_part(), tolerance_nm=1.0)
>>> unpack(pack(result.table)).part_name
'example'
"""
