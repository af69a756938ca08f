"""The page of results is what docs/measure_results.py writes of docs/results.json: no figure in it is typed."""

import json
import os
import sys
import unittest

from documents import read, repository


class Results(unittest.TestCase):
    def test_are_those_of_the_file(self):
        sys.path.insert(0, os.path.join(repository(), 'docs'))
        import measure_results

        self.assertEqual(measure_results.page(json.loads(read(repository(), 'docs/results.json'))), read(repository(), 'docs/results.md'))


if __name__ == '__main__':
    unittest.main()
