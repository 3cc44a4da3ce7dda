# kLargestEntry: entries of a direction whose largest entry was at most 1 before a pose turned it.
#
# Its length is at most √3, a body off rigid by 3.6e-6 stretches it by half of that, DoubleDouble rounds by far less (r).
{ |r| <= 1b-90 -> sqrt(3)*(1 + 2e-6)*(1 + r) - @kLargestEntry@ <= 0 }
